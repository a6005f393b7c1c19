// The command `recede` as a user runs it: arguments in; output, remarks and exit code back.
#pragma once

#include "temp_folder.h"
#include <recede/geometry/polygon_soup.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace recede::test {

/// All commands, in the order of `recede --help`.
inline constexpr const char* k_commands[] = {
    "bake",      "batch", "simplify", "compare", "diff",        "atlas",   "billboards", "shell",     "carve",
    "subdivide", "seams", "walk",     "info",    "progressive", "extract", "render",     "turntable", "dice"};

struct CommandResult {
  int code = -1;                ///< exit code; 128 + signal when a signal ended the process
  std::string output, remarks;  ///< standard output and standard error
};

/// Runs `recede` with both streams going into files.
CommandResult run_recede(const std::vector<std::string>& arguments);

/// Runs `recede` with both streams on a terminal (so `remarks` stays empty) and sends SIGINT as soon as
/// `awaited` has appeared there; never when that is empty.
CommandResult run_recede_on_terminal(const std::vector<std::string>& arguments, const std::string& awaited);

/// Runs `recede` and ends it by SIGKILL as soon as `is_time`, which is asked all the while; the exit code
/// tells whether it had ended before.
CommandResult run_recede_and_kill(const std::vector<std::string>& arguments,
                                  const std::function<bool()>& is_time);

/// Expects success and returns the one JSON document on standard output; null when there is none.
nlohmann::json json_of(const CommandResult& run);

/// Expects the exit code and exactly one line on standard error, `recede: ...`. Returns that line.
std::string complaint_of(const CommandResult& run, int code);

/// Expects the fields of an error, from the largest to the smallest, with their shares of the diagonal.
void expect_error_fields(const nlohmann::json& error, double diagonal);

/// Adds the names of all fields in a document, whatever their depth.
void collect_fields(const nlohmann::json& value, std::set<std::string>& names);

/// Expects docs/command-line.md to explain each of these fields.
void expect_explained(const std::set<std::string>& fields);

/// Names of everything below a folder, relative to it, sorted; empty when there is no such folder.
std::vector<std::string> names_below(const std::filesystem::path& folder);

/// How many they are, also while they change.
std::size_t n_names_below(const std::filesystem::path& folder);

/// Runs Khronos' validator. True when it finds no error; prints what it finds.
bool is_valid_gltf(const std::filesystem::path& file);
/// Whether `./dev test` has fetched the validator.
bool has_gltf_validator();

/// The JSON chunk of a GLB file.
nlohmann::json json_of_glb(const std::filesystem::path& file);

/// A closed surface with detail, as `sphere.ply` in `folder`. Returns its path.
std::string write_sphere(const TempFolder& folder, std::size_t faces, bool triangles = true);

}  // namespace recede::test
