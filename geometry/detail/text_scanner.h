// Words and numbers of a text in memory, with the line on which they stand.
#pragma once

#include <recede/geometry/detail/format_io.h>

#include <fast_float/fast_float.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace recede::detail {

/// Walks over a file's text. Blanks are spaces, tabs, carriage returns, and a backslash at the end of a line
/// together with that end; `#` starts a comment where a word could start.
class TextScanner {
 public:
  explicit TextScanner(const InputFile& file, std::size_t offset = 0, std::size_t line = 1)
      : file_(file), at_(file.content.data() + offset), line_(line) {}

  bool at_end() const { return at_ == end_; }
  std::size_t line() const { return line_; }
  std::size_t offset() const { return static_cast<std::size_t>(at_ - file_.content.data()); }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }
  [[noreturn]] void fail(const std::string& reason) const { file_.fail_at_line(line_, reason); }

  void skip_blanks() {
    for (;; ++at_) {
      if (at_ == end_ || static_cast<unsigned char>(*at_) > '\\') return;
      if (*at_ == ' ' || *at_ == '\t' || *at_ == '\r') continue;
      if (*at_ != '\\' || !skip_continuation()) return;
    }
  }

  /// Nothing but blanks and a comment is left on the line.
  bool at_line_end() {
    skip_blanks();
    return at_ == end_ || *at_ == '\n' || *at_ == '#';
  }

  void next_line() {
    const auto* found = static_cast<const char*>(std::memchr(at_, '\n', remaining()));
    at_ = found == nullptr ? end_ : found + 1;
    if (found != nullptr) ++line_;
  }

  /// Skips line ends as well. `comments` tells whether the format has them.
  void skip_space(bool comments) {
    for (;;) {
      skip_blanks();
      if (at_ == end_ || (*at_ != '\n' && !(comments && *at_ == '#'))) return;
      next_line();
    }
  }

  /// The characters up to the next blank or line end; empty at a line end.
  std::string_view word() {
    skip_blanks();
    const char* first = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {first, static_cast<std::size_t>(at_ - first)};
  }

  /// All that is left on the line, without blanks at either side; comments count as text.
  std::string_view rest_of_line() {
    skip_blanks();
    const auto* found = static_cast<const char*>(std::memchr(at_, '\n', remaining()));
    const char* last = found == nullptr ? end_ : found;
    const char* first = at_;
    at_ = last;
    while (last != first && is_space(last[-1])) --last;
    return {first, static_cast<std::size_t>(last - first)};
  }

  /// A decimal number on this line; "inf" and "nan" are numbers, too large ones are infinite.
  double number() {
    skip_blanks();
    const char* first = at_;
    if (remaining() > 1 && *first == '+' && first[1] != '-') ++first;
    double value = 0.0;
    const auto parsed = fast_float::from_chars(first, end_, value);
    if (parsed.ptr == first || (parsed.ptr != end_ && !ends_word(*parsed.ptr))) fail_number();
    at_ = parsed.ptr;
    return value;
  }

  /// An integer at this very place: "-12" of "-12/3". False when there is none; out of 64 bits counts as
  /// none.
  bool integer(std::int64_t& value) {
    const auto parsed = std::from_chars(at_, end_, value);
    if (parsed.ec != std::errc()) return false;
    at_ = parsed.ptr;
    return true;
  }

  /// Takes `c` when it stands at this very place.
  bool take(char c) {
    if (at_ == end_ || *at_ != c) return false;
    ++at_;
    return true;
  }

  /// A blank, a line's end or a comment follows immediately.
  bool at_word_end() const { return at_ == end_ || ends_word(*at_); }

  /// A whole number from 0; `what` names it in the error.
  std::size_t count(std::string_view what) {
    skip_blanks();
    const std::string_view text = TextScanner(*this).word();
    std::int64_t value = 0;
    if (!integer(value) || !at_word_end() || value < 0) fail(std::string(what) + " is " + in_quotes(text));
    return static_cast<std::size_t>(value);
  }

  static bool ends_word(char c) { return is_space(c) || c == '\\' || c == '#'; }
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

 private:
  bool skip_continuation() {
    const char* next = at_ + 1;
    if (next != end_ && *next == '\r') ++next;
    if (next == end_ || *next != '\n') return false;
    at_ = next;  // the caller steps over the line end
    ++line_;
    return true;
  }

  [[noreturn]] void fail_number() {
    const std::string_view text = word();
    fail(text.empty() ? "a number is missing" : in_quotes(text) + " isn't a number");
  }

  const InputFile& file_;
  const char* at_;
  const char* end_ = file_.content.data() + file_.content.size();
  std::size_t line_;
};

}  // namespace recede::detail
