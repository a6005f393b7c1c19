// The command `recede`: reads arguments, calls the library, prints. Exit codes: 0 done, 1 failure, 2 wrong
// usage.
#include "common.h"
#include "help_format.h"
#include <recede/geometry/error.h>
#include <recede/version.h>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

namespace {

constexpr int k_failure = 1;
constexpr int k_wrong_usage = 2;

int fail(const std::string& text, int code) {
  // One line, whatever the text held.
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  fmt::print(stderr, "recede: {}\n", line);
  return code;
}

/// Letters to insert, remove or exchange between two words.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t exchanged = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, exchanged});
    }
  }
  return row.back();
}

/// Empty: none is near.
std::string most_similar_option(const CLI::App& command, const std::string& name) {
  constexpr std::size_t k_farthest = 3;
  std::string nearest;
  std::size_t least = k_farthest;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& known : option->get_lnames()) {
      const std::size_t distance = edit_distance(name, "--" + known);
      if (distance >= least) continue;
      least = distance;
      nearest = "--" + known;
    }
  }
  return nearest;
}

/// Of an option whose values are missing, or some of them.
std::string needed_text(const CLI::Option& option, const std::string& name) {
  const int wanted = option.get_type_size();
  return fmt::format("{} needs {}: {}", name, wanted == 1 ? "a value" : fmt::format("{} values", wanted),
                     option.get_description());
}

/// What is wrong with the arguments. CLI11 asks for a command even when there is one that it doesn't know,
/// and lists what is left over backwards.
std::string usage_text(const CLI::App& app, const CLI::ParseError& error) {
  const auto unknown = app.remaining();
  const bool has_command = !app.get_subcommands().empty();
  if (!unknown.empty()) return fmt::format("unknown command or option {}", unknown.front());
  if (!has_command) return "a command is missing; `recede --help` lists them";
  const CLI::App& command = *app.get_subcommands().front();
  const std::string text = error.what(), conversion = "Could not convert: ";
  if (const auto equals = text.find(" = "); text.starts_with(conversion) && equals != text.npos) {
    const std::string name = text.substr(conversion.size(), equals - conversion.size());
    const std::string values = text.substr(equals + 3), last = values.substr(values.rfind(',') + 1);
    const CLI::Option* option = command.get_option_no_throw(name);
    const bool is_next_option = last.starts_with('-') && command.get_option_no_throw(last) != nullptr;
    if (option && is_next_option) return needed_text(*option, name);
    return fmt::format("{}: {} isn't a number", name, values);
  }
  if (const std::string required = " is required"; text.ends_with(required)) {
    const std::string name = text.substr(0, text.size() - required.size());
    if (const CLI::Option* option = command.get_option_no_throw(name))
      return fmt::format("{} needs {}: {}", command.get_name(), name, option->get_description());
  }
  if (const std::string_view several = "Requires at most 1 options be given from [";
      text.starts_with(several)) {
    std::string names = text.substr(several.size(), text.size() - several.size() - 1);
    for (std::size_t at = 0; (at = names.find(',', at)) != names.npos; at += 2) names.replace(at, 1, ", ");
    return fmt::format("only one of {} may be given", names);
  }
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ArgumentMismatch)) {
    const std::string name = text.substr(0, text.find(':'));
    if (text.find(" At Most ") != text.npos) return fmt::format("{} is given more than once", name);
    if (const CLI::Option* option = command.get_option_no_throw(name)) return needed_text(*option, name);
  }
  if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::ExtrasError)) return text;
  const std::string first = command.remaining().front();
  if (!first.starts_with('-')) return fmt::format("{}: one argument too many: {}", command.get_name(), first);
  const std::string meant = most_similar_option(command, first);
  return fmt::format("{} has no option {}{}", command.get_name(), first,
                     meant.empty() ? "" : fmt::format(" (did you mean {}?)", meant));
}

/// What holds for the options of all commands, and of their groups.
void finish_options(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands({})) finish_options(*command);
  for (CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    // CLI11 takes a minus before whole numbers and counts down from the largest one.
    if (type.starts_with("UINT")) option->check(recede::cli::not_negative().description(""));
    // Names may have commas in them, numbers don't.
    const bool is_list = option->get_expected_max() > 1 || option->get_type_size() > 1;
    if (is_list && type.find("TEXT") == type.npos) option->delimiter(',');
  }
}

/// As CLI11 takes them, the last one first. `help COMMAND` is `COMMAND --help`.
std::vector<std::string> arguments_of(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && arguments.front() == "help") {
    arguments.erase(arguments.begin());
    arguments.emplace_back("--help");
  }
  std::reverse(arguments.begin(), arguments.end());
  return arguments;
}

/// The number of threads belongs to the process; it must be known before any work starts.
int threads_argument(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::string name = "--threads";
    if (argument == name && i + 1 < argc) return std::atoi(argv[i + 1]);
    if (argument.starts_with(name + "=")) return std::atoi(argument.c_str() + name.size() + 1);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Level-of-detail geometry that says how wrong it is.", "recede");
  app.set_version_flag("--version", RECEDE_VERSION);
  app.require_subcommand(1);
  app.footer("`recede COMMAND --help` or `recede help COMMAND` explains a command and shows an example.");
  app.formatter(std::make_shared<recede::cli::HelpFormatter>());
  app.get_formatter()->label("SUBCOMMAND", "COMMAND");
  app.get_formatter()->label("Positionals", "Arguments");
  recede::cli::add_bake_command(app);
  recede::cli::add_batch_command(app);
  recede::cli::add_simplify_command(app);
  recede::cli::add_compare_command(app);
  recede::cli::add_diff_command(app);
  recede::cli::add_atlas_command(app);
  recede::cli::add_billboards_command(app);
  recede::cli::add_shell_command(app);
  recede::cli::add_carve_command(app);
  recede::cli::add_subdivide_command(app);
  recede::cli::add_seams_command(app);
  recede::cli::add_walk_command(app);
  recede::cli::add_info_command(app);
  recede::cli::add_progressive_command(app);
  recede::cli::add_extract_command(app);
  recede::cli::add_render_command(app);
  recede::cli::add_turntable_command(app);
  recede::cli::add_dice_command(app);
  finish_options(app);
  for (CLI::App* command : app.get_subcommands({})) command->group("Commands");
  recede::cli::catch_interrupts();
  std::unique_ptr<tbb::global_control> limit;
  if (const int threads = threads_argument(argc, argv); threads > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(threads));
  }
  try {
    app.parse(arguments_of(argc, argv));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help and version
    return fail(usage_text(app, error), k_wrong_usage);
  } catch (const recede::OptionError& error) {
    return fail(error.what(), k_wrong_usage);
  } catch (const std::bad_alloc&) {
    return fail("out of memory", k_failure);
  } catch (const std::exception& error) {
    return fail(error.what(), k_failure);
  }
  return 0;
}
