// What OpenCASCADE does to the process around it: it prints results of its own to standard output, where
// those of the command go, and runs into addresses that aren't there when a file is damaged.
#pragma once

#include <Message_SequenceOfPrinters.hxx>
#include <signal.h>

#include <array>
#include <iostream>
#include <sstream>
#include <streambuf>

namespace recede::detail {

/// While it is there, OpenCASCADE prints nothing, and its signals become its exceptions inside of `survives`.
/// Both belong to the process: one at a time. What others write to `std::cout` meanwhile is lost.
class CadGuard {
 public:
  CadGuard();
  ~CadGuard();
  CadGuard(const CadGuard&) = delete;
  CadGuard& operator=(const CadGuard&) = delete;

 private:
  static constexpr std::array<int, 4> k_of_damage{SIGSEGV, SIGBUS, SIGILL, SIGFPE};
  Message_SequenceOfPrinters printers_;
  std::ostringstream dropped_;
  std::streambuf* output_;
  std::array<struct sigaction, k_of_damage.size()> actions_;
};

/// Calls OpenCASCADE's `work(data)`; false when that ended in one of its exceptions or in a signal. Nothing
/// that it holds then is freed.
bool survives(void (*work)(void*), void* data);

template <typename Work>
bool survives(Work&& work) {
  return survives([](void* data) { (*static_cast<std::remove_reference_t<Work>*>(data))(); }, &work);
}

}  // namespace recede::detail
