#include "terminal_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

namespace recede::cli {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

void note_interrupt(int signal) {
  g_interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, note_interrupt);
  std::signal(SIGTERM, note_interrupt);
}

TerminalProgress::TerminalProgress(bool quiet) : draws_(!quiet && isatty(STDERR_FILENO) != 0) {}

TerminalProgress::~TerminalProgress() { clear(); }

void TerminalProgress::update(std::string_view stage, double fraction) {
  if (!draws_) return;
  const auto now = std::chrono::steady_clock::now();
  constexpr auto k_interval = std::chrono::milliseconds(50);
  if (drawn_ && stage == stage_ && now - last_ < k_interval) return;
  last_ = now;
  stage_ = stage;
  drawn_ = true;
  constexpr int k_width = 30;
  const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * k_width);
  const std::string bar =
      fmt::format("\r\x1b[K[{:<{}}] {:3.0f} % {}", std::string(static_cast<std::size_t>(filled), '#'),
                  k_width, 100 * fraction, stage);
  std::fputs(bar.c_str(), stderr);
  std::fflush(stderr);
}

bool TerminalProgress::cancel_requested() const { return g_interrupted != 0; }

void TerminalProgress::clear() {
  if (!drawn_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace recede::cli
