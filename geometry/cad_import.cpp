#include <recede/geometry/cad_import.h>
#include <recede/geometry/detail/cad_agreement.h>
#include <recede/geometry/detail/cad_assembly.h>
#include <recede/geometry/detail/cad_guard.h>
#include <recede/geometry/detail/cad_patch.h>
#include <recede/geometry/detail/cad_repair.h>
#include <recede/geometry/error.h>

#include <BRepBndLib.hxx>
#include <Bnd_Box.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <fmt/format.h>

#include <cmath>
#include <mutex>
#include <new>

namespace recede {

namespace fs = std::filesystem;

namespace {

using detail::CadBody;
using detail::CadFace;
using detail::CadProblem;

/// OpenCASCADE's errors as problems of the face at hand.
template <typename Work>
auto catching(Work&& work) {
  try {
    return work();
  } catch (const Standard_Failure& failure) {
    throw CadProblem{fmt::format("OpenCASCADE stumbles: {}", failure.DynamicType()->Name())};
  }
}

/// Turns the faces of one body into patches, each on its own.
class PartBuilder {
 public:
  PartBuilder(const CadBody& body, const CadImportOptions& options, CadModel& model)
      : body_(body), options_(options), model_(model) {
    Bnd_Box box;
    BRepBndLib::Add(body.shape, box, false);
    if (!box.IsVoid()) size_ = std::sqrt(box.SquareExtent());
  }

  CadPart run(const std::function<void()>& after_face) {
    part_.name = body_.name;
    for (std::size_t i = 0; i < body_.faces.size(); ++i) {
      add_face(i);
      after_face();
    }
    for (const std::string& line : detail::separate_distant_uses(part_, numbers_.edge_tolerances)) {
      model_.repairs.push_back(fmt::format("{} of \"{}\"", line, body_.name));
    }
    part_.n_edges = static_cast<Index>(numbers_.edges.Extent());
    part_.n_corners = static_cast<Index>(numbers_.corners.Extent());
    part_.is_closed = !left_out_ && detail::is_closed(part_);
    return std::move(part_);
  }

 private:
  std::string entity(std::size_t i) const { return fmt::format("face {} of \"{}\"", i + 1, body_.name); }
  void leave_out(std::size_t i, const std::string& reason) {
    model_.left_out.push_back({entity(i), reason});
    left_out_ = true;
  }

  void add_face(std::size_t i) {
    const TopAbs_Orientation orientation = body_.faces[i].face.Orientation();
    if (orientation == TopAbs_INTERNAL || orientation == TopAbs_EXTERNAL) {
      model_.left_out.push_back({entity(i), "it bounds nothing"});
      return;
    }
    try {
      catching([&] { add_patch(i, detail::trim_face(body_.faces[i].face, size_, options_.repair), {}); });
    } catch (const CadProblem& problem) {
      if (options_.repair) {
        add_mended(i, problem.reason);
      } else {
        leave_out(i, problem.reason);
      }
    }
  }

  void add_mended(std::size_t i, const std::string& reason) {
    try {
      catching([&] {
        const detail::MendedFace mended = detail::mend_face(body_.faces[i].face);
        std::vector<detail::TrimmedFace> faces;
        for (const TopoDS_Face& face : mended.faces) faces.push_back(detail::trim_face(face, size_, true));
        if (faces.empty()) throw CadProblem{reason};
        for (const detail::TrimmedFace& face : faces) add_patch(i, face, mended.originals);
      });
      model_.repairs.push_back(fmt::format("{}: mended, because {}", entity(i), reason));
    } catch (const CadProblem&) {
      // What is wrong with the file's own face says more than what is wrong with the mended one.
      leave_out(i, reason);
    }
  }

  void add_patch(std::size_t i, const detail::TrimmedFace& trimmed,
                 const TopTools_IndexedDataMapOfShapeShape& originals) {
    const CadFace& face = body_.faces[i];
    TrimmedPatch patch = detail::to_patch(trimmed, originals, numbers_);
    patch.is_reversed = face.face.Orientation() == TopAbs_REVERSED;
    patch.name = face.name.empty() ? std::to_string(i + 1) : face.name;
    patch.material = face.material;
    part_.patches.push_back(std::move(patch));
    for (const std::string& line : trimmed.left_out) model_.left_out.push_back({entity(i), line});
    for (const std::string& line : trimmed.repairs) {
      model_.repairs.push_back(fmt::format("{}: {}", entity(i), line));
    }
  }

  const CadBody& body_;
  const CadImportOptions& options_;
  CadModel& model_;
  double size_ = 0;
  bool left_out_ = false;
  CadPart part_;
  detail::PartNumbers numbers_;
};

/// Parts without a patch go, and the instances that place them.
void drop_empty_parts(CadModel& model) {
  std::vector<Index> numbers;
  std::vector<CadPart> parts;
  for (CadPart& part : model.parts) {
    const bool is_empty = part.patches.empty();
    numbers.push_back(is_empty ? k_no_index : static_cast<Index>(parts.size()));
    if (is_empty) {
      model.left_out.push_back({fmt::format("\"{}\"", part.name), "has no face that can be used"});
    } else {
      parts.push_back(std::move(part));
    }
  }
  model.parts = std::move(parts);
  std::vector<CadInstance> instances;
  for (CadInstance& instance : model.instances) {
    instance.part = numbers[instance.part];
    if (instance.part != k_no_index) instances.push_back(std::move(instance));
  }
  model.instances = std::move(instances);
}

std::string first_reason(const CadModel& model) {
  if (model.left_out.empty()) return "";
  return fmt::format(": {}: {}", model.left_out.front().entity, model.left_out.front().reason);
}

CadModel read_checked(const fs::path& path, const CadImportOptions& options, Progress* progress) {
  const detail::CadDocument document = detail::read_cad_document(path, progress);
  detail::CadAssembly assembly = detail::list_bodies(document, path.stem().string());
  CadModel model;
  model.instances = std::move(assembly.instances);
  model.materials = std::move(assembly.materials);
  model.left_out = document.left_out;
  model.left_out.insert(model.left_out.end(), assembly.left_out.begin(), assembly.left_out.end());
  std::size_t faces = 0, done = 0;
  for (const CadBody& body : assembly.bodies) faces += body.faces.size();
  const auto after_face = [&] {
    ++done;
    report_progress(progress, "convert", static_cast<double>(done) / static_cast<double>(faces));
  };
  for (const CadBody& body : assembly.bodies) {
    model.parts.push_back(PartBuilder(body, options, model).run(after_face));
  }
  drop_empty_parts(model);
  if (model.parts.empty()) {
    throw InputError::in_file(path.string(), "holds no face that can be used" + first_reason(model));
  }
  return model;
}

}  // namespace

bool can_read_cad() { return true; }

CadModel read_cad(const fs::path& path, const CadImportOptions& options, Progress* progress) {
  // Settings and messages of OpenCASCADE belong to the process.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const detail::CadGuard guard;
  try {
    return read_checked(path, options, progress);
  } catch (const CadProblem& problem) {
    throw InputError::in_file(path.string(), problem.reason);
  } catch (const Standard_Failure& failure) {
    throw InputError::in_file(path.string(),
                              fmt::format("OpenCASCADE stumbles: {}", failure.DynamicType()->Name()));
  } catch (const std::bad_alloc&) {
    throw InputError::in_file(path.string(), "doesn't fit in memory");
  }
}

}  // namespace recede
