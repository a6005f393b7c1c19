// As OpenCASCADE itself was built: signals jump to the nearest OCC_CATCH_SIGNALS.
#ifndef OCC_CONVERT_SIGNALS
#define OCC_CONVERT_SIGNALS
#endif
#include <recede/geometry/detail/cad_guard.h>

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <OSD.hxx>
#include <Standard_ErrorHandler.hxx>
#include <Standard_Failure.hxx>

namespace recede::detail {

namespace {

/// The other signals that OpenCASCADE would take: they are the caller's.
constexpr std::array<int, 4> k_of_others{SIGHUP, SIGINT, SIGQUIT, SIGSYS};

}  // namespace

CadGuard::CadGuard()
    : printers_(Message::DefaultMessenger()->Printers()), output_(std::cout.rdbuf(dropped_.rdbuf())) {
  Message::DefaultMessenger()->ChangePrinters().Clear();
  std::array<struct sigaction, k_of_others.size()> others;
  for (std::size_t i = 0; i < others.size(); ++i) sigaction(k_of_others[i], nullptr, &others[i]);
  for (std::size_t i = 0; i < actions_.size(); ++i) sigaction(k_of_damage[i], nullptr, &actions_[i]);
  OSD::SetSignal(OSD_SignalMode_Set, false);
  for (std::size_t i = 0; i < others.size(); ++i) sigaction(k_of_others[i], &others[i], nullptr);
}

CadGuard::~CadGuard() {
  for (std::size_t i = 0; i < actions_.size(); ++i) sigaction(k_of_damage[i], &actions_[i], nullptr);
  std::cout.rdbuf(output_);
  Message::DefaultMessenger()->ChangePrinters() = printers_;
}

bool survives(void (*work)(void*), void* data) {
  try {
    OCC_CATCH_SIGNALS
    work(data);
    return true;
  } catch (const Standard_Failure&) {
    return false;
  }
}

}  // namespace recede::detail
