// Textured shells as levels of a hierarchy.
#pragma once

#include <recede/lod/lod_hierarchy.h>
#include <recede/render/image.h>
#include <recede/shells/textured_shell.h>

#include <string>
#include <vector>

namespace recede {

struct ShellLevelOptions {
  std::vector<double> ratios{0.25, 0.0625};  ///< of simplified bases; see `HierarchyOptions`
  ViewSettings view{};
  SimplifyOptions simplify{};          ///< `target` is ignored
  Rgb matter_color{0.7f, 0.7f, 0.7f};  ///< linear light, where the texture has no colours
};

/// Level 0 is the shell with its texture, whose base `mesh` holds; from where the layer is no thicker than
/// the error allowed the base serves alone, and then simplified ones. These have the colour that base and
/// matter have on the average from above, lit from there, as vertex colours. `bound` of their errors is
/// certified: no point of the layer is farther from the base than the longest director; `max` and `rms` are
/// those of places that are seen from above. Throws `InputError` for what `TexturedShell::layer` refuses and
/// as `build_hierarchy` does.
LodHierarchy shell_hierarchy(const TexturedShell& textured, const std::string& name,
                             const ShellLevelOptions& options = {}, Progress* progress = nullptr);

}  // namespace recede
