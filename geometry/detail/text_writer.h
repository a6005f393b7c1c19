// Text under construction; numbers take the fewest digits that read back as the same value.
#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <string>
#include <string_view>
#include <utility>

namespace recede::detail {

class TextWriter {
 public:
  TextWriter& operator<<(char c) {
    text_ += c;
    return *this;
  }
  TextWriter& operator<<(std::string_view text) {
    text_ += text;
    return *this;
  }
  template <class Number>
  requires(std::integral<Number> || std::floating_point<Number>) TextWriter& operator<<(Number value) {
    std::array<char, 32> digits;  // the longest double takes 24
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text_.append(digits.data(), end);
    return *this;
  }
  /// Numbers with blanks between.
  template <class Vector>
  TextWriter& list(const Vector& values) {
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
      if (i > 0) text_ += ' ';
      *this << values[i];
    }
    return *this;
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace recede::detail
