// Sizes of memory as options.
#pragma once

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string>

namespace recede::cli {

/// Turns 500M, 8G, 256kb or 64KiB into bytes; a letter stands for 1024 of the one before.
inline CLI::Validator size_in_bytes() {
  const auto to_bytes = [](std::string& text) -> std::string {
    const std::string complaint =
        fmt::format("{} isn't a size such as 500M or 8G (whole numbers; without a letter bytes)", text);
    std::uint64_t number = 0;
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
    if (parsed.ec != std::errc() || parsed.ptr == text.data()) return complaint;
    std::string unit;
    for (const char* at = parsed.ptr; at != text.data() + text.size(); ++at) {
      if (*at != ' ') unit += static_cast<char>(std::tolower(static_cast<unsigned char>(*at)));
    }
    std::size_t power = 0;
    if (!unit.empty() && unit != "b") {
      power = std::string("bkmgt").find(unit.front());
      const std::string rest = unit.substr(1);
      if (power == 0 || power == std::string::npos || !(rest.empty() || rest == "b" || rest == "ib"))
        return complaint;
    }
    if (number > std::numeric_limits<std::uint64_t>::max() >> (10 * power)) return complaint;
    text = std::to_string(number << (10 * power));
    return "";
  };
  return CLI::Validator(to_bytes, "");
}

}  // namespace recede::cli
