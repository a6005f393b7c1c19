// Work in a process of its own, so that the memory peak of one measurement can't hide in that of another and
// a crash costs one row.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace recede::bench {

struct ChildAnswer {
  bool succeeded = false;
  std::string bytes;    ///< what the work returned
  std::string failure;  ///< otherwise why there is nothing, in words
};

/// Forks, runs `work` in the child and hands back its bytes. An exception, a signal or `seconds_allowed`
/// passing becomes a failure. The caller must not have started threads: only the forking one lives on in the
/// child.
ChildAnswer run_in_child(const std::function<std::string()>& work, unsigned seconds_allowed);

/// Resident memory of this process now, and at its highest since the last `forget_peak` (bytes; Linux).
std::size_t resident_bytes();
std::size_t peak_resident_bytes();
/// Starts a new peak at what is resident now.
void forget_peak();
/// How far that peak is above what was resident `before`; 0 where it isn't.
std::size_t peak_above(std::size_t before);

/// Plain values as bytes and back, in the order in which they were put. Reading past the end throws
/// `InputError`.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  T take() {
    T value;
    copy(&value, sizeof(T));
    return value;
  }
  template <class T>
  void take(std::vector<T>& values) {
    values.resize(take<std::size_t>());
    copy(values.data(), values.size() * sizeof(T));
  }
  std::string take_text();
  PolygonSoup take_soup();

 private:
  void copy(void* to, std::size_t size);
  std::string_view bytes_;
};

template <class T>
void put(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class T>
void put(std::string& bytes, const std::vector<T>& values) {
  put(bytes, values.size());
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

void put(std::string& bytes, const std::string& text);
/// Positions and faces.
void put(std::string& bytes, const PolygonSoup& soup);

/// One value alone.
template <class T>
std::string as_bytes(const T& value) {
  std::string bytes;
  put(bytes, value);
  return bytes;
}

}  // namespace recede::bench
