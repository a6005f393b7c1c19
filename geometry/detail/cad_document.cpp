#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/cad_document.h>
#include <recede/geometry/detail/cad_format.h>
#include <recede/geometry/detail/cad_guard.h>
#include <recede/geometry/detail/step_references.h>
#include <recede/geometry/error.h>

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <Message_ProgressIndicator.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <StepShape_FaceSurface.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <string_view>

namespace recede::detail {

namespace fs = std::filesystem;

namespace {

/// Hands OpenCASCADE's progress on, and asks it to stop.
class ProgressBridge final : public Message_ProgressIndicator {
 public:
  explicit ProgressBridge(Progress* progress) : progress_(progress) {}

 private:
  Standard_Boolean UserBreak() override { return progress_ != nullptr && progress_->cancel_requested(); }
  void Show(const Message_ProgressScope&, Standard_Boolean) override {
    if (progress_ != nullptr) progress_->update("read", std::clamp(GetPosition(), 0.0, 1.0));
  }
  Progress* progress_;
};

Handle(TDocStd_Document) new_document() {
  const Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(document->Main());
  return document;
}

std::string_view without_end_of_lines(std::string_view text) {
  const std::size_t last = text.find_last_not_of(" \t\r\n");
  return text.substr(0, last == text.npos ? 0 : last + 1);
}

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw InputError::in_file(path.string(), reason);
}

/// OpenCASCADE takes what it finds in a file that was cut short.
void check_step(const fs::path& path, const std::string& text) {
  if (text.find("ISO-10303-21") == text.npos) fail(path, "isn't a STEP file");
  if (text.find("END-ISO-10303-21") == text.npos) fail(path, "is cut short: END-ISO-10303-21 is missing");
}

/// Lines of 80 characters, of which number 73 says the section: S, G, D, P, and T in the last one.
void check_iges(const fs::path& path, const std::string& text) {
  const std::size_t line = text.find_first_of("\r\n");
  if (line == text.npos || line < 73 || std::string_view("SBC").find(text[72]) == std::string_view::npos) {
    fail(path, "isn't an IGES file");
  }
  const std::string_view whole = without_end_of_lines(text);
  const std::size_t start = whole.find_last_of("\r\n");
  const std::string_view last = whole.substr(start == whole.npos ? 0 : start + 1);
  if (last.size() < 73 || last[72] != 'T') fail(path, "is cut short: its last section is missing");
}

/// The last list of shapes ends in "*"; behind it stands the number of the whole shape and that of its place.
bool has_root(const std::string& text) {
  const std::size_t last = text.rfind('*');
  if (text.find("\nTShapes ") == text.npos || last == text.npos) return false;
  std::istringstream rest(text.substr(last + 1));
  char sign = 0;
  int shape = 0, place = 0;
  rest >> sign >> shape >> place;
  return rest && !rest.eof() && (sign == '+' || sign == '-');
}

void check_brep(const fs::path& path, const std::string& text) {
  if (text.find("CASCADE Topology V") == text.npos) fail(path, "isn't a BREP file");
  if (!has_root(text)) fail(path, "is cut short: the number of its shape is missing");
}

/// Shapes, names and colours of a STEP or IGES file, by OpenCASCADE's reader of its kind.
template <typename Reader>
CadDocument transfer(Reader& reader, const char* kind, const fs::path& path, Progress* progress) {
  reader.SetColorMode(true);
  reader.SetNameMode(true);
  reader.SetLayerMode(false);
  const std::string name = path.string();
  IFSelect_ReturnStatus status = IFSelect_RetFail;
  if (!survives([&] { status = reader.ReadFile(name.c_str()); }) || status != IFSelect_RetDone) {
    fail(path, std::string("can't be read as ") + kind);
  }
  report_progress(progress, "read", 0.5);
  CadDocument read{new_document(), {}, {}};
  const Handle(ProgressBridge) bridge = new ProgressBridge(progress);
  bool is_done = false;
  if (!survives([&] { is_done = reader.Transfer(read.document, bridge->Start()); })) {
    fail(path, "is damaged: OpenCASCADE can't make shapes of it");
  }
  report_progress(progress, "read", 1);
  if (!is_done) fail(path, "holds no shape");
  return read;
}

/// Faces of the file that are in no shape: OpenCASCADE's reader goes on without them, and says nothing.
std::vector<CadLeftOut> faces_without_shape(const STEPCAFControl_Reader& reader) {
  const Handle(XSControl_WorkSession) session = reader.Reader().WS();
  const Handle(StepData_StepModel) model = Handle(StepData_StepModel)::DownCast(session->Model());
  const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
  std::vector<CadLeftOut> left_out;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const auto face = Handle(StepShape_FaceSurface)::DownCast(model->Value(i));
    if (face.IsNull() || !TransferBRep::ShapeResult(process, face).IsNull()) continue;
    left_out.push_back({fmt::format("face #{} of the file", model->IdentLabel(face)),
                        "OpenCASCADE can't make a face of it"});
  }
  return left_out;
}

CadDocument read_step(const fs::path& path, const std::string& text, Progress* progress) {
  const StepReferences references = find_step_references(text);
  STEPCAFControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  // For names of faces OpenCASCADE goes through references without end where one leads nowhere or back.
  const bool is_sound = references.missing.empty() && !references.has_cycle;
  Interface_Static::SetIVal("read.stepcaf.subshapes.name", is_sound ? 1 : 0);
  STEPCAFControl_Reader reader;
  reader.SetPropsMode(false);
  CadDocument read = transfer(reader, "STEP", path, progress);
  for (const MissingEntity& missing : references.missing) {
    read.left_out.push_back({fmt::format("#{}", missing.number),
                             fmt::format("isn't in the file, though #{} refers to it", missing.user)});
  }
  for (CadLeftOut& face : faces_without_shape(reader)) read.left_out.push_back(std::move(face));
  return read;
}

CadDocument read_iges(const fs::path& path, Progress* progress) {
  IGESControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  IGESCAFControl_Reader reader;
  return transfer(reader, "IGES", path, progress);
}

CadDocument read_brep(const fs::path& path, const std::string& text, Progress* progress) {
  std::istringstream stream(text);
  // OpenCASCADE reads on for ever where a number is missing.
  stream.exceptions(std::ios::failbit);
  CadDocument read;
  const Handle(ProgressBridge) bridge = new ProgressBridge(progress);
  bool is_read = false;
  try {
    is_read = survives([&] { BRepTools::Read(read.shape, stream, BRep_Builder(), bridge->Start()); });
  } catch (const std::ios::failure&) {
    is_read = false;
  }
  if (!is_read) fail(path, "is damaged: OpenCASCADE can't make shapes of it");
  report_progress(progress, "read", 1);
  if (read.shape.IsNull()) fail(path, "can't be read as BREP");
  return read;
}

}  // namespace

CadDocument read_cad_document(const fs::path& path, Progress* progress) {
  const std::string text = read_whole_file(path);
  const std::optional<CadFormat> format = cad_format_of(path);
  if (format == CadFormat::step) {
    check_step(path, text);
    return read_step(path, text, progress);
  }
  if (format == CadFormat::iges) {
    check_iges(path, text);
    return read_iges(path, progress);
  }
  if (format == CadFormat::brep) {
    check_brep(path, text);
    return read_brep(path, text, progress);
  }
  fail(path, "unknown kind of CAD file; known are .step .stp .iges .igs .brep .brp");
}

}  // namespace recede::detail
