// Shells and their textures as Python holds them.
#pragma once

#include "calls.h"
#include <recede/shells/textured_shell.h>

namespace recede::python {

/// Shared, so that arrays outlive the lock.
struct BuiltShell {
  std::shared_ptr<const Shell> shell;
  std::size_t traced = 0;  ///< directors of a layer
};

/// The smaller versions of its texture are made when it is drawn first.
struct FilledShell {
  TexturedShell textured;
};

}  // namespace recede::python
