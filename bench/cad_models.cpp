#include "cad_models.h"

#include "cad_shapes.h"
#include "scratch_folder.h"
#include <recede/geometry/detail/cad_assembly.h>
#include <recede/geometry/detail/cad_guard.h>
#include <recede/geometry/error.h>
#include <recede/lod/cad_hierarchy.h>

#include <BRepTools.hxx>

#include <algorithm>
#include <optional>

namespace recede::bench {
namespace {

namespace fs = std::filesystem;

std::string name_of(const detail::CadBody& body, std::size_t face) {
  return body.faces[face].name.empty() ? std::to_string(face + 1) : body.faces[face].name;
}

/// Patches follow faces in order: one each, none where a face was left out, several where it was mended.
/// Nothing when the part isn't that of the body.
std::optional<std::vector<std::size_t>> match_faces(const detail::CadBody& body, const CadPart& part) {
  std::vector<std::size_t> faces;
  if (part.patches.size() == body.faces.size()) {
    for (std::size_t i = 0; i < part.patches.size(); ++i) faces.push_back(i);
    return faces;
  }
  std::size_t face = 0;
  for (const TrimmedPatch& patch : part.patches) {
    const bool is_next = face < body.faces.size() && name_of(body, face) == patch.name && !faces.empty();
    if (!is_next) face = faces.empty() ? 0 : faces.back() + 1;
    while (face < body.faces.size() && name_of(body, face) != patch.name) ++face;
    if (face >= body.faces.size()) return std::nullopt;
    faces.push_back(face);
  }
  return faces;
}

CadSubject load_file(const std::string& name, const fs::path& file) {
  CadSubject subject;
  subject.name = name;
  subject.model = read_cad(file);
  subject.diagonal = cad_diagonal(subject.model);
  const detail::CadGuard guard;
  const detail::CadDocument document = detail::read_cad_document(file, nullptr);
  const detail::CadAssembly assembly = detail::list_bodies(document, file.stem().string());
  std::size_t part = 0;
  for (const detail::CadBody& body : assembly.bodies) {
    if (part == subject.model.parts.size()) break;
    auto matched = match_faces(body, subject.model.parts[part]);
    if (!matched || subject.model.parts[part].name != body.name) continue;  // dropped by the import
    CadBench& made = subject.bodies.emplace_back();
    made.shape = body.shape;
    made.part = part;
    for (const detail::CadFace& face : body.faces) made.faces.push_back(face.face);
    made.face_of_patch = std::move(*matched);
    // Files may hold triangles.
    BRepTools::Clean(made.shape);
    ++part;
  }
  if (part != subject.model.parts.size()) throw InputError(name + ": parts and bodies don't match");
  return subject;
}

}  // namespace

std::size_t CadSubject::n_faces() const {
  std::size_t n = 0;
  for (const CadBench& body : bodies) n += body.faces.size();
  return n;
}

std::size_t CadSubject::n_patches() const {
  std::size_t n = 0;
  for (const CadPart& part : model.parts) n += part.patches.size();
  return n;
}

std::vector<CadSource> cad_sources(const fs::path& folder) {
  std::vector<CadSource> sources;
  for (const char* kind : {"step", "iges", "occ"}) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder / kind, ignored)) {
      const std::string stem = entry.path().stem().string();
      // These two hold points and an edge alone.
      if (!is_cad_path(entry.path()) || stem == "asahi" || stem == "edge") continue;
      sources.push_back({entry.path().filename().string(), stem == "terrain", entry.path()});
    }
  }
  if (sources.empty()) {
    throw InputError::in_file(folder.string(), "no CAD models; `./dev data` fetches them");
  }
  std::sort(sources.begin(), sources.end(),
            [](const CadSource& a, const CadSource& b) { return a.file < b.file; });
  sources.push_back({"wavy block, 16 holes", false, {}, [] { return test::cad_wavy_block(); }});
  sources.push_back({"bored sphere", false, {}, [] { return test::cad_bored_sphere(); }});
  sources.push_back({"rounded box", false, {}, [] { return test::cad_rounded_box(); }});
  sources.push_back({"sphere", false, {}, [] { return test::cad_sphere(); }});
  sources.push_back({"torus", false, {}, [] { return test::cad_torus(); }});
  sources.push_back({"cone", false, {}, [] { return test::cad_cone(); }});
  sources.push_back({"cylinder", false, {}, [] { return test::cad_cylinder(); }});
  sources.push_back({"plate, 400 holes", false, {}, [] { return test::cad_plate(20); }});
  sources.push_back({"screw of primitives", false, {}, [] { return test::cad_screw(); }});
  sources.push_back({"swept conics", false, {}, [] { return test::cad_compound(test::cad_swept_faces()); }});
  sources.push_back({"offset face", false, {}, [] { return test::cad_offset_face(); }});
  sources.push_back({"periodic B-spline", false, {}, [] { return test::cad_periodic_patch(); }});
  return sources;
}

CadSubject load_cad(const CadSource& source) {
  if (!source.make) return load_file(source.name, source.file);
  const ScratchFolder folder;
  test::write_brep(folder.path() / "shape.brep", source.make());
  return load_file(source.name, folder.path() / "shape.brep");
}

CadSubject load_cad_assembly(int patches) {
  const ScratchFolder folder;
  test::write_step_assembly(folder.path() / "assembly.step", test::cad_screws_on_plates(patches));
  return load_file("screws on plates", folder.path() / "assembly.step");
}

}  // namespace recede::bench
