// The script of the report's viewer, made from render/viewer/ by the build.
#pragma once

#include <string_view>

namespace recede::detail {

/// JavaScript, compressed (zlib), as base64. Empty: there was no npm when the library was built.
std::string_view viewer_program();

}  // namespace recede::detail
