#include "child_process.h"

#include <recede/geometry/error.h>

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>

namespace recede::bench {
namespace {

constexpr char k_done = 'd', k_failed = 'f';

void write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // the parent is gone; nobody is left to tell
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::string read_all(int file) {
  std::string bytes;
  std::vector<char> block(1 << 16);
  for (;;) {
    const ssize_t got = ::read(file, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return bytes;
    bytes.append(block.data(), static_cast<std::size_t>(got));
  }
}

[[noreturn]] void be_child(const std::function<std::string()>& work, int answer, unsigned seconds_allowed) {
  // Nobody waits for the answer of a child whose parent is gone.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::alarm(seconds_allowed);
  std::string bytes;
  try {
    bytes = k_done + work();
  } catch (const std::bad_alloc&) {
    bytes = k_failed + std::string("out of memory");
  } catch (const std::exception& error) {
    bytes = k_failed + std::string(error.what());
  }
  write_all(answer, bytes);
  // Not exit: the destructors and buffers at the parent's exit are the parent's.
  ::_exit(0);
}

std::string describe_end(int status, unsigned seconds_allowed) {
  if (!WIFSIGNALED(status)) return fmt::format("ended without an answer, code {}", WEXITSTATUS(status));
  if (WTERMSIG(status) == SIGALRM) return fmt::format("no result within {} s", seconds_allowed);
  return fmt::format("crashed ({})", ::strsignal(WTERMSIG(status)));
}

/// A line of /proc/self/status in bytes.
std::size_t status_bytes(std::string_view key) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with(key)) return std::stoull(line.substr(key.size())) * 1024;
  }
  return 0;
}

}  // namespace

ChildAnswer run_in_child(const std::function<std::string()>& work, unsigned seconds_allowed) {
  int ends[2];
  if (::pipe(ends) != 0) throw Error(fmt::format("no pipe: {}", std::strerror(errno)));
  // What stands in the buffers would be written twice.
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) throw Error(fmt::format("no child process: {}", std::strerror(errno)));
  if (child == 0) {
    ::close(ends[0]);
    be_child(work, ends[1], seconds_allowed);
  }
  ::close(ends[1]);
  ChildAnswer answer;
  answer.bytes = read_all(ends[0]);
  ::close(ends[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  const bool ended_well = WIFEXITED(status) && WEXITSTATUS(status) == 0 && !answer.bytes.empty();
  const char mark = ended_well ? answer.bytes.front() : '\0';
  if (!answer.bytes.empty()) answer.bytes.erase(0, 1);
  answer.succeeded = mark == k_done;
  if (mark == k_failed) answer.failure = answer.bytes;
  if (!ended_well) answer.failure = describe_end(status, seconds_allowed);
  return answer;
}

std::size_t resident_bytes() { return status_bytes("VmRSS:"); }

std::size_t peak_resident_bytes() { return status_bytes("VmHWM:"); }

void forget_peak() {
  // proc(5): 5 sets the peak resident set size to the present one.
  std::ofstream("/proc/self/clear_refs") << "5";
}

std::size_t peak_above(std::size_t before) {
  const std::size_t peak = peak_resident_bytes();
  return peak > before ? peak - before : 0;
}

std::string ByteReader::take_text() {
  std::vector<char> letters;
  take(letters);
  return {letters.begin(), letters.end()};
}

PolygonSoup ByteReader::take_soup() {
  PolygonSoup soup;
  take(soup.positions);
  take(soup.face_offsets);
  take(soup.corner_vertices);
  return soup;
}

void put(std::string& bytes, const std::string& text) {
  put(bytes, std::vector<char>(text.begin(), text.end()));
}

void put(std::string& bytes, const PolygonSoup& soup) {
  put(bytes, soup.positions);
  put(bytes, soup.face_offsets);
  put(bytes, soup.corner_vertices);
}

void ByteReader::copy(void* to, std::size_t size) {
  if (size > bytes_.size()) throw InputError("a child process gave too few bytes");
  if (size > 0) std::memcpy(to, bytes_.data(), size);
  bytes_.remove_prefix(size);
}

}  // namespace recede::bench
