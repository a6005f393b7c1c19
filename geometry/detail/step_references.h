// What entities of a STEP file refer to, read from its text: OpenCASCADE passes over what isn't there.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace recede::detail {

/// An entity that isn't in the file, and the first one that refers to it.
struct MissingEntity {
  std::uint64_t number = 0, user = 0;
};

struct StepReferences {
  std::vector<MissingEntity> missing;  ///< by their numbers
  bool has_cycle = false;              ///< an entity that needs itself, by way of others or not
};

StepReferences find_step_references(std::string_view text);

}  // namespace recede::detail
