#include "run_recede.h"

#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace recede::test {

namespace fs = std::filesystem;

namespace {

/// Where the child's streams go.
struct Streams {
  std::string output, error;
};

pid_t start(const std::vector<std::string>& arguments, const Streams& streams) {
  std::vector<std::string> words{RECEDE_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr int k_flags = O_RDWR | O_CREAT | O_NOCTTY;
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, streams.output.c_str(), k_flags, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, streams.error.c_str(), k_flags, 0600);
  pid_t process = -1;
  const int failed = posix_spawn(&process, RECEDE_COMMAND, &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error(fmt::format("{}: {}", RECEDE_COMMAND, std::strerror(failed)));
  return process;
}

int wait_for(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// The controlling side of a new terminal.
class Terminal {
 public:
  Terminal() : file_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (file_ < 0 || grantpt(file_) != 0 || unlockpt(file_) != 0)
      throw std::runtime_error("no terminal to be had");
    // Kept open so that reading ends with the process and not before it has started.
    child_side_ = open(ptsname(file_), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  ~Terminal() {
    close(file_);
    if (child_side_ >= 0) close(child_side_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  std::string name() const { return ptsname(file_); }
  void release_child_side() {
    close(child_side_);
    child_side_ = -1;
  }
  /// Waits for more text and appends it. False at the end: the process has let go of the terminal.
  bool read_more(std::string& text) const {
    char block[4096];
    const ssize_t got = read(file_, block, sizeof block);
    if (got <= 0) return false;
    text.append(block, static_cast<std::size_t>(got));
    return true;
  }

 private:
  int file_, child_side_ = -1;
};

/// `meanwhile` gets the process.
template <typename Meanwhile>
CommandResult run_into_files(const std::vector<std::string>& arguments, Meanwhile&& meanwhile) {
  const TempFolder folder;
  const Streams streams{folder / "output", folder / "error"};
  CommandResult run;
  const pid_t process = start(arguments, streams);
  meanwhile(process);
  run.code = wait_for(process);
  run.output = read_whole_file(streams.output);
  run.remarks = read_whole_file(streams.error);
  return run;
}

}  // namespace

CommandResult run_recede(const std::vector<std::string>& arguments) {
  return run_into_files(arguments, [](pid_t) {});
}

CommandResult run_recede_and_kill(const std::vector<std::string>& arguments,
                                  const std::function<bool()>& is_time) {
  return run_into_files(arguments, [&](pid_t process) {
    siginfo_t ended{};
    // It stays there to be waited for.
    while (ended.si_pid == 0 && !is_time())
      waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOHANG | WNOWAIT);
    kill(process, SIGKILL);
  });
}

CommandResult run_recede_on_terminal(const std::vector<std::string>& arguments, const std::string& awaited) {
  Terminal terminal;
  const pid_t process = start(arguments, {terminal.name(), terminal.name()});
  terminal.release_child_side();
  CommandResult run;
  bool interrupted = awaited.empty();
  while (terminal.read_more(run.output)) {
    if (interrupted || run.output.find(awaited) == run.output.npos) continue;
    kill(process, SIGINT);
    interrupted = true;
  }
  run.code = wait_for(process);
  return run;
}

nlohmann::json json_of(const CommandResult& run) {
  EXPECT_EQ(run.code, 0) << run.remarks;
  const nlohmann::json document = nlohmann::json::parse(run.output, nullptr, false);
  EXPECT_FALSE(document.is_discarded()) << run.output;
  return document.is_discarded() ? nlohmann::json() : document;
}

std::string complaint_of(const CommandResult& run, int code) {
  EXPECT_EQ(run.code, code) << run.remarks;
  EXPECT_EQ(run.output, "");
  EXPECT_THAT(run.remarks, testing::StartsWith("recede: "));
  EXPECT_EQ(std::count(run.remarks.begin(), run.remarks.end(), '\n'), 1) << run.remarks;
  EXPECT_THAT(run.remarks, testing::EndsWith("\n"));
  return run.remarks.substr(0, run.remarks.find('\n'));
}

void expect_error_fields(const nlohmann::json& error, double diagonal) {
  EXPECT_GT(error.at("rms").get<double>(), 0);
  EXPECT_GE(error.at("max").get<double>(), error.at("rms").get<double>());
  EXPECT_GE(error.at("bound").get<double>(), error.at("max").get<double>());
  for (const std::string name : {"max", "rms", "bound"}) {
    EXPECT_DOUBLE_EQ(error.at(name + "_relative").get<double>(), error.at(name).get<double>() / diagonal);
  }
}

void collect_fields(const nlohmann::json& value, std::set<std::string>& names) {
  if (value.is_object()) {
    for (const auto& [name, field] : value.items()) names.insert(name);
  }
  for (const auto& field : value) {
    if (field.is_structured()) collect_fields(field, names);
  }
}

void expect_explained(const std::set<std::string>& fields) {
  EXPECT_FALSE(fields.empty());
  const std::string page = read_whole_file(fs::path(RECEDE_SOURCE) / "docs/command-line.md");
  for (const std::string& field : fields) {
    EXPECT_NE(page.find("`" + field + "`"), page.npos) << field << " isn't explained";
  }
}

std::vector<std::string> names_below(const fs::path& folder) {
  std::vector<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.push_back(fs::relative(entry.path(), folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::size_t n_names_below(const fs::path& folder) {
  std::error_code is_gone;
  std::size_t n = 0;
  for (fs::recursive_directory_iterator at(folder, is_gone), end; !is_gone && at != end;
       at.increment(is_gone))
    ++n;
  return n;
}

bool has_gltf_validator() { return fs::exists(fs::path(RECEDE_NODE_MODULES) / "gltf-validator"); }

bool is_valid_gltf(const fs::path& file) {
  const auto command =
      fmt::format("node '{}' '{}' '{}'", RECEDE_VALIDATE_GLTF, RECEDE_NODE_MODULES, file.string());
  return std::system(command.c_str()) == 0;
}

nlohmann::json json_of_glb(const fs::path& file) {
  const std::string content = read_whole_file(file);
  constexpr std::size_t k_length_at = 12, k_json_at = 20;
  std::uint32_t length = 0;
  if (content.size() < k_json_at) throw std::runtime_error(file.string() + ": too short for a GLB");
  std::memcpy(&length, content.data() + k_length_at, sizeof length);
  return nlohmann::json::parse(content.substr(k_json_at, length));
}

std::string write_sphere(const TempFolder& folder, std::size_t faces, bool triangles) {
  const fs::path file = folder / "sphere.ply";
  write_soup(file, make_displaced_sphere(faces, triangles));
  return file.string();
}

}  // namespace recede::test
