// kinetostat-step: reads STEP files with Open CASCADE, in a process of its own, because it may
// crash or run out of time or memory on a damaged file, and because its many shared libraries would
// slow down the start of everything else. What is read and written is described in
// fea/surface/step_protocol.h.
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_ProjectPointOnCurve.hxx>
#include <Geom_Curve.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPControl_Reader.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <Standard_Version.hxx>
#include <StepShape_Face.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_Label.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XCAFPrs.hxx>
#include <XCAFPrs_Style.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <sys/mman.h>
#include <unistd.h>

#include "kinetostat/fea/surface/step_protocol.h"

#include "child.h"

namespace {

using namespace kinetostat;
using namespace kinetostat::fea::step;

// The bytes under a name that Open CASCADE can open.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : descriptor_(memfd_create("link.step", 0)) {
    if (descriptor_ < 0 || !write_all(descriptor_, bytes))
      throw Impossible("there is no memory for the file");
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string name() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

// What Open CASCADE holds of the file: solids, faces by number, their names and colours.
struct Shape {
  TopoDS_Shape whole;
  TopTools_IndexedMapOfShape solids, faces;
  std::vector<std::string> face_names, face_colours, solid_names;
};

std::string text_of(const TCollection_ExtendedString& name) {
  std::string text(static_cast<std::size_t>(name.LengthOfCString()) + 1, '\0');
  Standard_PCharacter at = text.data();
  name.ToUTF8CString(at);
  text.resize(std::string(text.c_str()).size());
  return text;
}

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  return label.FindAttribute(TDataStd_Name::GetID(), name) ? text_of(name->Get()) : "";
}

// Names of faces stand in the entities of the file; a face placed several times has one shape.
std::map<const TopoDS_TShape*, std::string> names_in_file(const STEPControl_Reader& reader) {
  std::map<const TopoDS_TShape*, std::string> names;
  const Handle(XSControl_WorkSession) session = reader.WS();
  const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
  const Handle(Interface_InterfaceModel) model = session->Model();
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(StepShape_Face) face = Handle(StepShape_Face)::DownCast(model->Value(i));
    if (face.IsNull() || face->Name().IsNull()) continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(process, face);
    if (!shape.IsNull()) names[shape.TShape().get()] = face->Name()->ToCString();
  }
  return names;
}

std::string hex(const Quantity_Color& color) {
  const auto part = [](double linear) {
    const double srgb =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    return static_cast<int>(std::lround(255 * std::clamp(srgb, 0.0, 1.0)));
  };
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", part(color.Red()), part(color.Green()),
                part(color.Blue()));
  return text;
}

// The colour of a face is its own, else that of its solid, else that of the whole.
class Colours {
 public:
  explicit Colours(const TDF_LabelSequence& roots) {
    for (int i = 1; i <= roots.Length(); ++i)
      XCAFPrs::CollectStyleSettings(roots.Value(i), TopLoc_Location(), styles_);
  }
  std::string of(const TopoDS_Shape& face, const TopoDS_Shape& solid,
                 const TopoDS_Shape& root) const {
    for (const TopoDS_Shape* shape : {&face, &solid, &root}) {
      if (shape->IsNull()) continue;
      if (const XCAFPrs_Style* style = find(*shape))
        if (style->IsSetColorSurf()) return hex(style->GetColorSurf());
    }
    return "";
  }

 private:
  const XCAFPrs_Style* find(const TopoDS_Shape& shape) const {
    if (const XCAFPrs_Style* exact = styles_.Seek(shape)) return exact;
    return styles_.Seek(shape.Oriented(TopAbs_FORWARD));
  }
  XCAFPrs_IndexedDataMapOfShapeStyle styles_;
};

// Names of solids: those of the parts that hold them.
void name_solids(const Handle(XCAFDoc_ShapeTool) & tool, const TDF_Label& label,
                 const TopLoc_Location& place, const std::string& given, Shape& shape) {
  TDF_Label part = label;
  if (XCAFDoc_ShapeTool::IsReference(label)) XCAFDoc_ShapeTool::GetReferredShape(label, part);
  std::string name = name_of(part);
  if (name.empty()) name = given;
  TDF_LabelSequence members;
  if (XCAFDoc_ShapeTool::IsAssembly(part)) XCAFDoc_ShapeTool::GetComponents(part, members);
  for (int i = 1; i <= members.Length(); ++i)
    name_solids(tool, members.Value(i), place * XCAFDoc_ShapeTool::GetLocation(members.Value(i)),
                name, shape);
  if (!members.IsEmpty()) return;
  const TopoDS_Shape own = XCAFDoc_ShapeTool::GetShape(part).Moved(place);
  for (TopExp_Explorer at(own, TopAbs_SOLID); at.More(); at.Next())
    if (const int number = shape.solids.FindIndex(at.Current()))
      shape.solid_names[static_cast<std::size_t>(number - 1)] = name;
}

void number_faces(const TDF_LabelSequence& roots, Shape& shape) {
  BRep_Builder builder;
  TopoDS_Compound whole;
  builder.MakeCompound(whole);
  for (int i = 1; i <= roots.Length(); ++i)
    builder.Add(whole, XCAFDoc_ShapeTool::GetShape(roots.Value(i)));
  TopExp::MapShapes(whole, TopAbs_SOLID, shape.solids);
  if (shape.solids.IsEmpty()) {
    TopExp::MapShapes(whole, TopAbs_FACE, shape.faces);
    shape.whole = whole;
    return;
  }
  TopoDS_Compound solids;
  builder.MakeCompound(solids);
  for (int i = 1; i <= shape.solids.Extent(); ++i) {
    builder.Add(solids, shape.solids(i));
    TopExp::MapShapes(shape.solids(i), TopAbs_FACE, shape.faces);
  }
  shape.whole = solids;
}

// The solid that has a face, or nothing.
int solid_of(const Shape& shape, const TopoDS_Shape& face) {
  for (int i = 1; i <= shape.solids.Extent(); ++i)
    for (TopExp_Explorer at(shape.solids(i), TopAbs_FACE); at.More(); at.Next())
      if (at.Current().IsSame(face)) return i;
  return 0;
}

void read(const std::string& bytes, Shape& shape) {
  const MemoryFile file(bytes);
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  STEPCAFControl_Reader reader;
  if (reader.ReadFile(file.name().c_str()) != IFSelect_RetDone)
    throw Impossible("Open CASCADE cannot read it");
  if (!reader.Transfer(document)) throw Impossible("Open CASCADE finds no shape in it");
  const Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  TDF_LabelSequence roots;
  tool->GetFreeShapes(roots);
  number_faces(roots, shape);
  if (shape.faces.IsEmpty()) throw Impossible("it holds no surface");
  shape.solid_names.resize(static_cast<std::size_t>(shape.solids.Extent()));
  for (int i = 1; i <= roots.Length(); ++i)
    name_solids(tool, roots.Value(i), XCAFDoc_ShapeTool::GetLocation(roots.Value(i)), "", shape);
  const auto names = names_in_file(reader.Reader());
  const Colours colours(roots);
  const TopoDS_Shape root =
      roots.Length() == 1 ? XCAFDoc_ShapeTool::GetShape(roots.Value(1)) : TopoDS_Shape();
  for (int i = 1; i <= shape.faces.Extent(); ++i) {
    const TopoDS_Shape& face = shape.faces(i);
    const auto name = names.find(face.TShape().get());
    shape.face_names.push_back(name == names.end() ? "" : name->second);
    const int solid = solid_of(shape, face);
    shape.face_colours.push_back(
        colours.of(face, solid > 0 ? shape.solids(solid) : TopoDS_Shape(), root));
  }
}

void put(std::vector<double>& list, const gp_XYZ& v) {
  list.insert(list.end(), {v.X(), v.Y(), v.Z()});
}

// The number of FaceKind (surface_mesh.h), a point, a direction and the radius of a face.
struct Figures {
  int kind = 0;
  gp_XYZ point, direction;
  double radius = 0;
};

Figures figures_of(const TopoDS_Face& face) {
  const BRepAdaptor_Surface surface(face);
  const auto about = [](int kind, const gp_Ax1& axis, double radius) {
    return Figures{kind, axis.Location().XYZ(), axis.Direction().XYZ(), radius};
  };
  switch (surface.GetType()) {
    case GeomAbs_Plane: {
      const gp_Pln plane = surface.Plane();
      gp_XYZ normal = plane.Axis().Direction().XYZ();
      if (!plane.Direct()) normal.Reverse();
      if (face.Orientation() == TopAbs_REVERSED) normal.Reverse();
      return {1, plane.Location().XYZ(), normal, 0};
    }
    case GeomAbs_Cylinder:
      return about(2, surface.Cylinder().Axis(), surface.Cylinder().Radius());
    case GeomAbs_Cone:
      return about(3, surface.Cone().Axis(), surface.Cone().RefRadius());
    case GeomAbs_Sphere:
      return {4, surface.Sphere().Location().XYZ(), gp_XYZ(0, 0, 0), surface.Sphere().Radius()};
    case GeomAbs_Torus:
      return about(5, surface.Torus().Axis(), surface.Torus().MinorRadius());
    default:
      return {};
  }
}

void describe_faces(const Shape& shape, Answer& answer) {
  for (int i = 1; i <= shape.faces.Extent(); ++i) {
    const TopoDS_Face face = TopoDS::Face(shape.faces(i));
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(face, properties);
    const Figures figures = figures_of(face);
    answer.kinds.push_back(figures.kind);
    answer.solid_of_face.push_back(solid_of(shape, face));
    answer.figures.push_back(properties.Mass());
    put(answer.figures, properties.CentreOfMass().XYZ());
    put(answer.figures, figures.point);
    put(answer.figures, figures.direction);
    answer.figures.push_back(figures.radius);
    answer.face_names += shape.face_names[static_cast<std::size_t>(i - 1)] + '\0';
    answer.face_colours += shape.face_colours[static_cast<std::size_t>(i - 1)] + '\0';
  }
  for (const std::string& name : shape.solid_names) answer.solid_names += name + '\0';
}

void add_triangles(const TopoDS_Face& face, int number, Answer& answer) {
  TopLoc_Location place;
  const Handle(Poly_Triangulation) facets = BRep_Tool::Triangulation(face, place);
  if (facets.IsNull())
    throw Impossible("Open CASCADE cannot cut face " + std::to_string(number) + " into facets");
  const auto base = static_cast<std::int32_t>(answer.points.size() / 3);
  for (int i = 1; i <= facets->NbNodes(); ++i)
    put(answer.points, facets->Node(i).Transformed(place.Transformation()).XYZ());
  for (int i = 1; i <= facets->NbTriangles(); ++i) {
    int a = 0, b = 0, c = 0;
    facets->Triangle(i).Get(a, b, c);
    if (face.Orientation() == TopAbs_REVERSED) std::swap(b, c);
    answer.triangles.insert(answer.triangles.end(), {base + a - 1, base + b - 1, base + c - 1});
    answer.face_of_triangle.push_back(number);
  }
}

Answer facets(const Request& request) {
  if (request.numbers.size() != 2 || !(request.numbers[0] > 0) || !(request.numbers[1] > 0))
    throw std::invalid_argument("facets: an angle and a distance");
  Shape shape;
  read(request.step, shape);
  Bnd_Box box;
  BRepBndLib::Add(shape.whole, box);
  IMeshTools_Parameters parameters;  // one thread: the same facets every time
  parameters.Angle = request.numbers[0];
  parameters.Deflection = request.numbers[1] * std::sqrt(box.SquareExtent());
  parameters.MinSize = 1e-3 * parameters.Deflection;
  const BRepMesh_IncrementalMesh mesh(shape.whole, parameters);
  Answer answer;
  describe_faces(shape, answer);
  for (int i = 1; i <= shape.faces.Extent(); ++i)
    add_triangles(TopoDS::Face(shape.faces(i)), i, answer);
  return answer;
}

// -- Nearest points ------------------------------------------------------------------------------

// Points of faces, of edges between two faces and of corners between more.
class Nearest {
 public:
  explicit Nearest(const Shape& shape) : shape_(shape), surfaces_(shape.face_names.size()) {}

  gp_Pnt on(const gp_Pnt& point, const std::int32_t* faces, std::size_t count) {
    if (count == 0) return point;
    if (count == 1) return on_face(point, faces[0]);
    const TopAbs_ShapeEnum kind = count == 2 ? TopAbs_EDGE : TopAbs_VERTEX;
    gp_Pnt best = point;
    double least = std::numeric_limits<double>::infinity();
    for (const TopoDS_Shape& shared : common(faces, count, kind)) {
      const std::optional<gp_Pnt> found = kind == TopAbs_VERTEX
                                              ? BRep_Tool::Pnt(TopoDS::Vertex(shared))
                                              : on_edge(point, TopoDS::Edge(shared));
      if (!found || !(found->Distance(point) < least)) continue;
      least = found->Distance(point);
      best = *found;
    }
    return best;
  }

 private:
  gp_Pnt on_face(const gp_Pnt& point, std::int32_t number) {
    auto& surface = surfaces_.at(static_cast<std::size_t>(number - 1));
    if (surface.IsNull())
      surface = new ShapeAnalysis_Surface(BRep_Tool::Surface(TopoDS::Face(shape_.faces(number))));
    return surface->Value(surface->ValueOfUV(point, 1e-9));
  }

  static std::optional<gp_Pnt> on_edge(const gp_Pnt& point, const TopoDS_Edge& edge) {
    if (BRep_Tool::Degenerated(edge)) return {};
    double first = 0, last = 0;
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
    if (curve.IsNull()) return {};
    gp_Pnt best = curve->Value(first);
    if (curve->Value(last).Distance(point) < best.Distance(point)) best = curve->Value(last);
    const GeomAPI_ProjectPointOnCurve projection(point, curve, first, last);
    if (projection.NbPoints() > 0 && projection.LowerDistance() < best.Distance(point))
      best = projection.NearestPoint();
    return best;
  }

  // Edges or corners that all of the faces have.
  const std::vector<TopoDS_Shape>& common(const std::int32_t* faces, std::size_t count,
                                          TopAbs_ShapeEnum kind) {
    const auto [entry, is_new] =
        common_.try_emplace(std::vector<std::int32_t>(faces, faces + count));
    if (!is_new) return entry->second;
    TopTools_IndexedMapOfShape first;
    TopExp::MapShapes(shape_.faces(faces[0]), kind, first);
    for (int i = 1; i <= first.Extent(); ++i) {
      bool in_all = true;
      for (std::size_t k = 1; k < count && in_all; ++k) {
        TopTools_IndexedMapOfShape other;
        TopExp::MapShapes(shape_.faces(faces[k]), kind, other);
        in_all = other.Contains(first(i));
      }
      if (in_all) entry->second.push_back(first(i));
    }
    return entry->second;
  }

  const Shape& shape_;
  std::vector<Handle(ShapeAnalysis_Surface)> surfaces_;
  std::map<std::vector<std::int32_t>, std::vector<TopoDS_Shape>> common_;
};

Answer project(const Request& request) {
  Shape shape;
  read(request.step, shape);
  for (const std::int32_t face : request.faces)
    if (face < 1 || face > shape.faces.Extent()) throw std::invalid_argument("project: a face");
  Nearest nearest(shape);
  Answer answer;
  for (std::size_t i = 0; 3 * i < request.points.size(); ++i) {
    const gp_Pnt point(request.points[3 * i], request.points[3 * i + 1], request.points[3 * i + 2]);
    const auto begin = static_cast<std::size_t>(request.face_start[i]);
    const auto end = static_cast<std::size_t>(request.face_start[i + 1]);
    put(answer.points, nearest.on(point, request.faces.data() + begin, end - begin).XYZ());
  }
  return answer;
}

bool is_consistent(const Request& request) {
  if (request.operation != "project") return request.points.empty();
  const std::size_t count = request.points.size() / 3;
  return request.points.size() == 3 * count && request.face_start.size() == count + 1 &&
         request.face_start.front() == 0 &&
         std::is_sorted(request.face_start.begin(), request.face_start.end()) &&
         static_cast<std::size_t>(request.face_start.back()) == request.faces.size();
}

int run() {
  Request request;
  if (!decode(read_all(STDIN_FILENO), request) || !is_consistent(request)) return exit_bad_request;
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  Answer answer;
  if (request.operation == "facets")
    answer = facets(request);
  else if (request.operation == "project")
    answer = project(request);
  else
    return exit_bad_request;
  return write_all(answer_descriptor, encode(answer)) ? exit_done : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::printf("kinetostat-step %s with Open CASCADE %s, LGPL-2.1 with an exception\n",
                KINETOSTAT_VERSION, OCC_VERSION_COMPLETE);
    return 0;
  }
  limit_process(argc, argv);
  const auto work = [] {
    try {
      return run();
    } catch (const Standard_OutOfMemory&) {
      throw std::bad_alloc();
    } catch (const Standard_Failure& error) {
      throw Impossible(error.GetMessageString());
    }
  };
  end_with(work, exit_out_of_memory, exit_impossible);
}
