// OpenCASCADE prints what it does to standard output, where results of the command go.
#pragma once

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_SequenceOfPrinters.hxx>

namespace recede::detail {

/// Takes the printers of OpenCASCADE's messages away, and gives them back.
class CadSilence {
 public:
  CadSilence() : printers_(Message::DefaultMessenger()->Printers()) {
    Message::DefaultMessenger()->ChangePrinters().Clear();
  }
  ~CadSilence() { Message::DefaultMessenger()->ChangePrinters() = printers_; }
  CadSilence(const CadSilence&) = delete;
  CadSilence& operator=(const CadSilence&) = delete;

 private:
  Message_SequenceOfPrinters printers_;
};

}  // namespace recede::detail
