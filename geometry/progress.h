// One interface for long work: how far it is, what it does now, and whether it should stop.
#pragma once

#include <string_view>

namespace recede {

/// Receives the progress of an operation. Calls come from one thread at a time.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `stage` names the present step; `fraction` of it is done, 0 to 1.
  virtual void update(std::string_view stage, double fraction) = 0;
  /// True asks the operation to stop; it then throws `Cancelled`.
  virtual bool cancel_requested() const { return false; }
};

/// Passes progress on when there is a receiver. Throws `Cancelled` when that receiver asks to stop.
void report_progress(Progress* progress, std::string_view stage, double fraction);

}  // namespace recede
