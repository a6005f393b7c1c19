// What work complains about.
#pragma once

#include <recede/geometry/error.h>

#include <string>

namespace recede::test {

/// The text of the error that `work` ends with; "" when there is none.
template <typename Work>
std::string error_text(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace recede::test
