// Appearances as Python holds them.
#pragma once

#include <recede/render/appearance.h>

#include <memory>

namespace recede::python {

/// Shared, so that pictures outlive the lock.
struct SharedAppearance {
  std::shared_ptr<const Appearance> appearance;
};

}  // namespace recede::python
