#include <recede/geometry/error.h>
#include <recede/lod/hierarchy_folder.h>

#include <algorithm>
#include <string>
#include <vector>

namespace recede {

namespace fs = std::filesystem;

namespace {

constexpr auto k_list = "hierarchy.json";

std::vector<fs::path> hierarchies_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failed)) {
    // Others are those of a run that was killed.
    if (entry.path().extension() == ".recede" && fs::exists(entry.path() / k_list))
      found.push_back(entry.path());
  }
  if (failed) throw InputError::in_file(folder.string(), failed.message());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

fs::path hierarchy_folder(const fs::path& path) {
  if (!fs::is_directory(path)) {
    if (path.filename() != k_list || !fs::exists(path)) return {};
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
  }
  if (fs::exists(path / k_list)) return path;
  const std::vector<fs::path> found = hierarchies_in(path);
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw InputError::in_file(path.string(),
                              "holds no hierarchy, which is a folder NAME.recede with hierarchy.json in it");
  std::string names;
  for (const fs::path& folder : found) names += (names.empty() ? "" : ", ") + folder.string();
  throw InputError::in_file(path.string(), "holds several hierarchies; give one of them: " + names);
}

}  // namespace recede
