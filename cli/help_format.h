// How help looks: kinds of values in plain words instead of CLI11's names of types.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace recede::cli {

/// `NUMBER`, `N` for whole numbers, `NAME` where there is a choice, `FILE`, or what the option itself says;
/// then the range, whether it is required, and which other options it needs or excludes.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override;
  /// Without the `{false}` of flags that switch off.
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  /// Groups of options look alike, whether or not they exclude each other.
  std::string make_expanded(const CLI::App* group) const override;
};

}  // namespace recede::cli
