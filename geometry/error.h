// The exceptions that Recede throws. Each carries one line that a person can act on.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace recede {

/// Base of every exception thrown on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file, mesh or value that can't be used. The text names the place: `dragon.obj:12: reason`.
class InputError : public Error {
 public:
  using Error::Error;
  /// `path: reason`
  static InputError in_file(const std::string& path, const std::string& reason);
  /// `path:line: reason`; lines count from 1.
  static InputError at_line(const std::string& path, std::size_t line, const std::string& reason);
  /// `path: byte offset: reason`; offsets count from 0.
  static InputError at_byte(const std::string& path, std::size_t offset, const std::string& reason);
};

/// An option outside its range, or options that contradict each other.
class OptionError : public Error {
 public:
  using Error::Error;
};

/// The caller's `Progress` asked to stop. Inputs are untouched and no file was written.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

}  // namespace recede
