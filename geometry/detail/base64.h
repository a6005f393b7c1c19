// Bytes as text, RFC 4648 section 4.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace recede::detail {

std::string encode_base64(std::string_view bytes);

/// Nothing when `text` isn't base64. Missing padding is accepted.
std::optional<std::string> decode_base64(std::string_view text);

}  // namespace recede::detail
