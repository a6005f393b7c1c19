#include <recede/geometry/error.h>
#include <recede/geometry/progress.h>

namespace recede {

void report_progress(Progress* progress, std::string_view stage, double fraction) {
  if (progress == nullptr) return;
  if (progress->cancel_requested()) throw Cancelled();
  progress->update(stage, fraction);
}

}  // namespace recede
