#include "fea/surface/step_parts.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace kinetostat::test {
namespace {

// What a face is called, and whether it is red.
struct Label {
  std::string name = {};
  bool red = false;
};
using Labels = std::function<Label(const BRepAdaptor_Surface&)>;

void label_faces(const TopoDS_Shape& solid, const Labels& labels, const TDF_Label& part,
                 const Handle(TDocStd_Document) & document) {
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const auto colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
  for (TopExp_Explorer at(solid, TopAbs_FACE); at.More(); at.Next()) {
    const Label label = labels(BRepAdaptor_Surface(TopoDS::Face(at.Current())));
    if (label.name.empty() && !label.red) continue;
    const TDF_Label face = shapes->AddSubShape(part, at.Current());
    if (!label.name.empty()) TDataStd_Name::Set(face, label.name.c_str());
    if (label.red)
      colours->SetColor(face, Quantity_Color(1, 0, 0, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  }
}

void write(const std::filesystem::path& file, const TopoDS_Shape& solid, const Labels& labels) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const TDF_Label part = shapes->AddShape(solid, false);
  XCAFDoc_DocumentTool::ColorTool(document->Main())
      ->SetColor(part, Quantity_Color(0.2, 0.2, 0.2, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  label_faces(solid, labels, part, document);
  STEPCAFControl_Writer writer;
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);
  if (!writer.Transfer(document) || writer.Write(file.c_str()) != IFSelect_RetDone)
    throw std::runtime_error("Open CASCADE writes no STEP file");
}

// Solids that touch, by name.
void write_solids(const std::filesystem::path& file,
                  const std::vector<std::pair<std::string, TopoDS_Shape>>& solids) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  for (const auto& [name, solid] : solids)
    TDataStd_Name::Set(shapes->AddShape(solid, false), name.c_str());
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document) || writer.Write(file.c_str()) != IFSelect_RetDone)
    throw std::runtime_error("Open CASCADE writes no STEP file");
}

bool is_at(double a, double b) { return std::abs(a - b) < 1e-6; }

}  // namespace

void write_round_bar(const std::filesystem::path& file, double diameter, double length) {
  const gp_Ax2 axis(gp_Pnt(0, 0, 0), gp_Dir(1, 0, 0));
  write(file, BRepPrimAPI_MakeCylinder(axis, diameter / 2, length).Shape(),
        [length](const BRepAdaptor_Surface& face) -> Label {
          if (face.GetType() != GeomAbs_Plane) return {};
          return {.name = is_at(face.Plane().Location().X(), length) ? "head" : "foot"};
        });
}

void write_round_bar_in_two(const std::filesystem::path& file, double diameter, double length) {
  const auto half = [&](double x) {
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, 0, 0), gp_Dir(1, 0, 0)), diameter / 2,
                                    length / 2)
        .Shape();
  };
  write_solids(file, {{"near half", half(0)}, {"far half", half(length / 2)}});
}

void write_core_and_sleeve(const std::filesystem::path& file, double inner, double outer,
                           double length) {
  const gp_Ax2 axis(gp_Pnt(0, 0, 0), gp_Dir(1, 0, 0));
  const TopoDS_Shape core = BRepPrimAPI_MakeCylinder(axis, inner / 2, length).Shape();
  const TopoDS_Shape whole = BRepPrimAPI_MakeCylinder(axis, outer / 2, length).Shape();
  write_solids(file, {{"core", core}, {"sleeve", BRepAlgoAPI_Cut(whole, core).Shape()}});
}

void write_bored_block(const std::filesystem::path& file, double diameter) {
  const TopoDS_Shape block = BRepPrimAPI_MakeBox(gp_Pnt(-30, -30, -10), gp_Pnt(30, 30, 10)).Shape();
  const gp_Ax2 axis(gp_Pnt(0, 0, -20), gp_Dir(0, 0, 1));
  const TopoDS_Shape bore = BRepPrimAPI_MakeCylinder(axis, diameter / 2, 40).Shape();
  write(file, BRepAlgoAPI_Cut(block, bore).Shape(),
        [](const BRepAdaptor_Surface&) { return Label{}; });
}

void write_perforated_plate(const std::filesystem::path& file, double length) {
  const double pitch = length / 18;
  TopoDS_Shape plate = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), gp_Pnt(length, 60, 10)).Shape();
  for (int i = 1; i <= 17; ++i)
    for (const int row : {1, 2}) {
      const gp_Ax2 axis(gp_Pnt(i * pitch, 20 * row, -5), gp_Dir(0, 0, 1));
      plate = BRepAlgoAPI_Cut(plate, BRepPrimAPI_MakeCylinder(axis, 3, 20).Shape()).Shape();
    }
  write(file, plate, [&](const BRepAdaptor_Surface& face) -> Label {
    if (face.GetType() == GeomAbs_Cylinder) {
      const gp_Pnt at = face.Cylinder().Location();
      const auto i = static_cast<int>(std::lround(at.X() / pitch));
      const auto row = static_cast<int>(std::lround(at.Y() / 20));
      return {.name = "bore " + std::to_string(i) + "." + std::to_string(row),
              .red = i == 9 && row == 2};
    }
    if (std::abs(face.Plane().Axis().Direction().X()) < 0.5) return {};
    return {.name = is_at(face.Plane().Location().X(), length) ? "right" : "left"};
  });
}

}  // namespace kinetostat::test
