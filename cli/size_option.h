// Sizes of memory as options.
#pragma once

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cctype>
#include <string>

namespace recede::cli {

/// Turns 500M, 8G, 256kb or 64KiB into bytes; a letter stands for 1024 of the one before. What CLI11 says of
/// other texts names its types and units.
inline CLI::Validator size_in_bytes() {
  const auto to_bytes = [units = CLI::AsSizeValue(false)](std::string& text) -> std::string {
    std::string bytes = text;
    try {
      const bool is_number = !text.empty() && std::isdigit(static_cast<unsigned char>(text.front())) != 0;
      if (is_number && units(bytes).empty()) {
        text = bytes;
        return "";
      }
    } catch (const CLI::ValidationError&) {
    }
    return fmt::format("{} isn't a size such as 500M or 8G (whole numbers; without a letter bytes)", text);
  };
  return CLI::Validator(to_bytes, "");
}

}  // namespace recede::cli
