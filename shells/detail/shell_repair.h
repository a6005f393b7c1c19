// What makes a layer valid.
#pragma once

#include <recede/shells/detail/shell_directors.h>

namespace recede::detail {

/// Sets the layer's tops and validity from its traced ends.
void repair_layer(const ShellSurface& surface, double side, bool may_change, ShellLayer& layer,
                  Progress* progress);

}  // namespace recede::detail
