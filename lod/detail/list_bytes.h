// Lists of plain values as bytes, for files that this process alone reads.
#pragma once

#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace recede::detail {

/// A vector, or a text.
template <typename List>
void put_list(std::string& bytes, const List& list) {
  const std::size_t n = list.size();
  bytes.append(reinterpret_cast<const char*>(&n), sizeof n);
  bytes.append(reinterpret_cast<const char*>(list.data()), n * sizeof(*list.data()));
}

/// Takes what `put_list` put there.
template <typename Value>
std::vector<Value> take_list(std::string_view& bytes) {
  std::size_t n = 0;
  std::memcpy(&n, bytes.data(), sizeof n);
  std::vector<Value> list(n);
  if (n > 0) std::memcpy(static_cast<void*>(list.data()), bytes.data() + sizeof n, n * sizeof(Value));
  bytes.remove_prefix(sizeof n + n * sizeof(Value));
  return list;
}

}  // namespace recede::detail
