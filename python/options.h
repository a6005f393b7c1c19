// Options from dictionaries whose keys are their names.
#pragma once

#include "calls.h"
#include <recede/lod/displacement_bake.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace recede::python {

/// Throws `TypeError` with the name when the value is of another type.
template <typename Value>
Value value_of(const py::dict& from, const char* key) {
  try {
    return from[key].cast<Value>();
  } catch (const py::cast_error&) {
    throw py::type_error(std::string(key) + ": a value of another type is needed, not " +
                         py::repr(from[key]).cast<std::string>());
  }
}

template <typename Value>
void read(const py::dict& from, const char* key, Value& to) {
  if (from.contains(key) && !from[key].is_none()) to = value_of<Value>(from, key);
}

/// A dictionary of numbers by name.
inline void read(const py::dict& from, const char* key, std::vector<std::pair<std::string, double>>& to) {
  if (!from.contains(key) || from[key].is_none()) return;
  for (const auto& [name, number] : value_of<std::map<std::string, double>>(from, key))
    to.emplace_back(name, number);
}

/// What the name stands for; hyphens and underscores are alike. Throws `OptionError` with all names when it
/// is none of them.
template <typename Choice>
Choice choice(const char* key, const std::string& name, const std::map<std::string, Choice>& names) {
  const auto plain = [](std::string text) {
    std::replace(text.begin(), text.end(), '_', '-');
    return text;
  };
  for (const auto& [text, value] : names) {
    if (plain(text) == plain(name)) return value;
  }
  std::string known;
  for (const auto& [text, value] : names) known += (known.empty() ? "" : ", ") + text;
  throw OptionError(std::string(key) + ": " + name + " isn't one of " + known);
}

template <typename Choice>
void read_choice(const py::dict& from, const char* key, const std::map<std::string, Choice>& names,
                 Choice& to) {
  if (from.contains(key)) to = choice(key, value_of<std::string>(from, key), names);
}

/// `maps` names those that are made; the others are `map_size` and its like, and `search_distance`.
MapOptions read_map_options(const py::dict& from);

}  // namespace recede::python
