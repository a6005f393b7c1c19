#include "help_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

namespace recede::cli {
namespace {

/// CLI11 writes `TYPE:check` for options with checks.
struct ValueText {
  std::string kind, range;
};

ValueText value_text(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t colon = type.find(':');
  const std::string name = type.substr(0, colon);
  const std::string check = colon == type.npos ? "" : type.substr(colon + 1);
  const std::string& own = option.get_option_text();
  // Where the check is a choice its text is the kind.
  const bool is_choice = !check.empty() && (name == "TEXT" || check.front() == '{' || check == "NAME");
  if (is_choice) return {own.empty() ? check : own, ""};
  if (!own.empty()) return {own, check};
  if (name == "TEXT") return {"FILE", check};
  return {name == "FLOAT" ? "NUMBER" : "N", check};
}

std::string names_of(const std::set<CLI::Option*>& options) {
  std::set<std::string> names;  // in an order that stays
  for (const CLI::Option* option : options) names.insert(option->get_name());
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  std::string text;
  if (option->get_expected_max() > 0) {  // flags have none
    const auto [kind, range] = value_text(*option);
    text += " " + kind;
    if (option->get_option_text().empty() &&
        option->get_expected_max() == CLI::detail::expected_max_vector_size)
      text += " ...";
    if (!range.empty()) text += fmt::format(" ({})", range);
    if (option->get_required()) text += " (required)";
  }
  if (!option->get_needs().empty()) text += fmt::format(" (with {})", names_of(option->get_needs()));
  if (!option->get_excludes().empty())
    text += fmt::format(" (not with {})", names_of(option->get_excludes()));
  return text;
}

std::string HelpFormatter::make_option_name(const CLI::Option* option, bool is_positional) const {
  const std::string name = Formatter::make_option_name(option, is_positional);
  return name.substr(0, name.find('{'));
}

std::string HelpFormatter::make_expanded(const CLI::App* group) const {
  const auto options = group->get_options([group](const CLI::Option* option) {
    return option->nonpositional() && option != group->get_help_ptr();
  });
  return "\n" + make_group(group->get_group(), false, {options.begin(), options.end()});
}

}  // namespace recede::cli
