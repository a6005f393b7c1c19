// Reading text as if it were a file, and what reading it complains about.
#pragma once

#include "error_text.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>

#include <gmock/gmock.h>

#include <string>
#include <string_view>

namespace recede::test {

inline PolygonSoup read_text(std::string_view name, std::string_view content) {
  const TempFolder folder;
  return read_soup(folder.write(name, content));
}

/// The complaint about a file, from its name on; "" when there is none.
inline std::string complaint(std::string_view name, std::string_view content) {
  const TempFolder folder;
  try {
    read_soup(folder.write(name, content));
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), text.npos) << text;
    return text.substr(text.find(name));
  }
  return "";
}

}  // namespace recede::test
