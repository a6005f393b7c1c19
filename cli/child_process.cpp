#include "child_process.h"

#include <recede/geometry/error.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

namespace recede::cli {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw InputError(fmt::format("{}: {}", what, std::strerror(errno)));
}

std::string content_of(std::FILE* file) {
  std::rewind(file);
  std::string text;
  std::array<char, 4096> block;
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), file))
    text.append(block.data(), got);
  return text;
}

/// In the new process, where nothing may be allocated.
[[noreturn]] void become(char* const* words, int output, int remarks, pid_t parent) {
  constexpr int k_not_started = 127;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(k_not_started);  // it ended in between
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) _exit(k_not_started);
  if (dup2(output, STDOUT_FILENO) < 0 || dup2(remarks, STDERR_FILENO) < 0) _exit(k_not_started);
  execv(words[0], words);
  _exit(k_not_started);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& words)
    : output_(std::tmpfile(), std::fclose), remarks_(std::tmpfile(), std::fclose) {
  if (!output_ || !remarks_) refuse("a temporary file");
  std::vector<std::string> copies = words;
  std::vector<char*> pointers;
  for (std::string& word : copies) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  start_ = std::chrono::steady_clock::now();
  const int output = fileno(output_.get()), remarks = fileno(remarks_.get());
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ < 0) refuse(words[0]);
  if (process_ == 0) become(pointers.data(), output, remarks, parent);
}

ChildProcess::~ChildProcess() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::optional<ChildResult> ChildProcess::poll() {
  int status = 0;
  rusage usage{};
  if (process_ < 0 || wait4(process_, &status, WNOHANG, &usage) != process_) return {};
  process_ = -1;
  ChildResult result;
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.output = content_of(output_.get());
  result.remarks = content_of(remarks_.get());
  result.seconds = seconds();
  result.peak_bytes = static_cast<std::size_t>(usage.ru_maxrss) * 1024;
  return result;
}

double ChildProcess::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void ChildProcess::send(int signal) const {
  if (process_ > 0) kill(process_, signal);
}

std::string own_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

}  // namespace recede::cli
