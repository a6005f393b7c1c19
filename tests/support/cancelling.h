// Progress that asks to stop.
#pragma once

#include <recede/geometry/progress.h>

#include <string>
#include <string_view>

namespace recede::test {

/// From the first report of a stage on, or from the beginning.
class Cancelling : public Progress {
 public:
  explicit Cancelling(std::string_view stage = {}) : stage_(stage), stops_(stage.empty()) {}
  void update(std::string_view stage, double) override { stops_ = stops_ || stage == stage_; }
  bool cancel_requested() const override { return stops_; }

 private:
  std::string stage_;
  bool stops_;
};

}  // namespace recede::test
