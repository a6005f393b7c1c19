// What stands in for the import in a build without OpenCASCADE.
#include <recede/geometry/cad_import.h>
#include <recede/geometry/error.h>

namespace recede {

bool can_read_cad() { return false; }

CadModel read_cad(const std::filesystem::path& path, const CadImportOptions&, Progress*) {
  throw InputError::in_file(path.string(), "this build reads no CAD files: it was made without OpenCASCADE");
}

}  // namespace recede
