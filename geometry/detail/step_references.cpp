#include <recede/geometry/detail/step_references.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <unordered_map>

namespace recede::detail {

namespace {

using References = std::unordered_map<std::uint64_t, std::vector<std::uint64_t>>;  // of each entity

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Reads on after '#'.
std::uint64_t read_number(std::string_view text, std::size_t& at) {
  std::uint64_t number = 0;
  while (at < text.size() && is_digit(text[at]))
    number = 10 * number + static_cast<unsigned>(text[at++] - '0');
  return number;
}

// Behind a text in quotes or a comment that begins at `at`; `at` itself where none does.
std::size_t skipped(std::string_view text, std::size_t at) {
  std::size_t end = at;
  if (text[at] == '\'') {
    end = text.find('\'', at + 1);
    if (end != text.npos) ++end;
  } else if (text.substr(at, 2) == "/*") {
    end = text.find("*/", at + 2);
    if (end != text.npos) end += 2;
  }
  return std::min(end, text.size());
}

// `#1 = NAME(... #2 ...);`: a number at the start of a statement is the entity's own.
References read_references(std::string_view text) {
  References references;
  std::vector<std::uint64_t>* current = nullptr;
  bool is_start = true;
  for (std::size_t at = 0; at < text.size();) {
    if (const std::size_t behind = skipped(text, at); behind != at) {
      at = behind;
      continue;
    }
    const char c = text[at++];
    if (c == ';') {
      is_start = true;
      current = nullptr;
    } else if (c == '#' && at < text.size() && is_digit(text[at])) {
      const std::uint64_t number = read_number(text, at);
      if (is_start) current = &references[number];
      if (!is_start && current != nullptr) current->push_back(number);
      is_start = false;
    } else if (std::isspace(static_cast<unsigned char>(c)) == 0) {
      is_start = false;
    }
  }
  return references;
}

// By taking away, again and again, what needs nothing that is left.
bool has_cycle(const References& references) {
  std::unordered_map<std::uint64_t, std::size_t> n_needed;
  std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> users;
  std::vector<std::uint64_t> done;
  for (const auto& [number, needed] : references) {
    std::size_t& n = n_needed[number];
    for (const std::uint64_t other : needed) {
      if (!references.contains(other)) continue;
      users[other].push_back(number);
      ++n;
    }
    if (n == 0) done.push_back(number);
  }
  for (std::size_t i = 0; i < done.size(); ++i) {
    for (const std::uint64_t user : users[done[i]]) {
      if (--n_needed[user] == 0) done.push_back(user);
    }
  }
  return done.size() < references.size();
}

}  // namespace

StepReferences find_step_references(std::string_view text) {
  const References references = read_references(text);
  std::map<std::uint64_t, std::uint64_t> missing;  // and its first user
  for (const auto& [number, needed] : references) {
    for (const std::uint64_t other : needed) {
      if (references.contains(other)) continue;
      const auto [at, is_new] = missing.try_emplace(other, number);
      if (!is_new) at->second = std::min(at->second, number);
    }
  }
  StepReferences result;
  for (const auto& [number, user] : missing) result.missing.push_back({number, user});
  result.has_cycle = has_cycle(references);
  return result;
}

}  // namespace recede::detail
