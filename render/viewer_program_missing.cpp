#include <recede/render/detail/viewer_program.h>

namespace recede::detail {

std::string_view viewer_program() { return {}; }

}  // namespace recede::detail
