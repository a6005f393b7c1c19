// Baked maps as Python holds them.
#pragma once

#include <recede/lod/displacement_bake.h>

#include <memory>

namespace recede::python {

/// Shared, so that arrays and measurements outlive the lock.
struct SharedMaps {
  std::shared_ptr<const BakedMaps> maps;
};

}  // namespace recede::python
