// The models that everything is measured on.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace recede::bench {

/// How a model comes to be. `load` runs in a child process, for it may start threads.
struct ModelSource {
  std::string name;
  bool polygons = false;         ///< quads, measured for how many of them stay
  std::filesystem::path file{};  ///< it is read from; empty: made by code
  std::function<PolygonSoup()> load;
};

/// An OFF file of the folder, which may be missing.
ModelSource model_file(const std::filesystem::path& data, const std::string& name);

/// All models but the largest when `quick`; files are looked for in `data`.
std::vector<ModelSource> all_models(const std::filesystem::path& data, bool quick);

/// Displaced spheres of growing size, up to 300 thousand triangles when `quick`, else 10 million.
std::vector<ModelSource> growing_models(bool quick);

/// Throws `InputError` when its file is missing.
void require_file(const ModelSource& source);

/// The model with its vertices welded, those that several fans of faces share split again, and its positions
/// rounded to single precision: every system gets the same bytes, also those that know floats or manifolds
/// only. Throws `InputError` with the reason when it can't be made.
PolygonSoup load_model(const ModelSource& source);

}  // namespace recede::bench
