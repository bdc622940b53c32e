// Tables of readings that are wrong in one way or several: every mistake is reported at once, with
// its place, the value and what would work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/common/error.h"
#include "kinetostat/vjm/chain/chain_builder.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::malformed_table_test {
namespace {

using testing::HasSubstr;

const std::string head =
    "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, angle: deg, time: s}\n"
    "displacement: difference\nreadings: readings.csv\n";

// Two joints in series, A1 about z and A2 about y.
vjm::Manipulator arm() {
  vjm::ChainBuilder chain("arm");
  chain.actuator("A1", vjm::Motion::rz, 1e5).offset(spatial::Pose::translation({0.3, 0, 0}));
  chain.actuator("A2", vjm::Motion::ry, 1e5).offset(spatial::Pose::translation({0.4, 0, 0}));
  return vjm::Manipulator("arm", {chain.build()});
}

struct Malformed {
  std::string name;
  std::string csv;
  std::vector<std::string> said;  // parts of the message, each about one mistake
  std::string more = {};          // in the campaign file
};

std::string message_of(const Malformed& table) {
  try {
    read_campaign(test::write_campaign(head + table.more, table.csv), arm());
  } catch (const common::InputError& error) {
    return error.what();
  }
  return "was read";
}

class MalformedTable : public testing::TestWithParam<Malformed> {};

TEST_P(MalformedTable, IsReportedWithEveryPlaceAndCure) {
  const std::string message = message_of(GetParam());
  for (const std::string& part : GetParam().said) EXPECT_THAT(message, HasSubstr(part));
}

const Malformed tables[] = {
    // One mistake: file:line:column: column: what. cure.
    {"Letters",
     "fz,dz\n1,2\n1,abc\n",
     {"readings.csv:3:3: dz: 'abc' is not a number. Write a number"}},
    {"UnitInCell", "fz,dz\n12 N,2\n", {":2:1: fz: '12 N' is not a number. Write the number alone"}},
    {"TwoPoints", "fz,dz\n1.2.3,2\n", {":2:1: fz: '1.2.3' is not a number"}},
    {"CommaAmongPoints",
     "fz;dz\n1;0.5\n2;0.25\n3;0,75\n",
     {":4:3: dz: '0,75' is not a number. Write the decimals with a point"}},
    {"PointAmongCommas",
     "fz;dz\n1;0,5\n2;0,25\n3;0.75\n",
     {":4:3: dz: '0.75' is not a number. Write the decimals with a comma"}},
    {"EitherSign",
     "fz;dz\n1,000;2\n",
     {":2:1: fz: '1,000' is not a number. Say 'decimal: comma' or"}},
    {"Infinite",
     "fz,dz\n1,inf\n",
     {":2:3: dz: 'inf' is not a finite number. Leave the cell empty"}},
    {"TooLarge", "fz,dz\n1e200,1\n", {":2:1: fz: '1e200' is too large or too small"}},
    {"SpreadsheetError",
     "fz,dz\n#DIV/0!,1\n1,1\n",
     {":2:1: fz: '#DIV/0!' is not a number. A spreadsheet could not compute this"}},
    {"SpreadsheetErrorInside",
     "fz,dz\n1,#DIV/0!\n",
     {":2:3: dz: '#DIV/0!' is not a number. A spreadsheet could not compute this"}},
    {"EmptyLoad", "fz,dz\n,1\n", {":2:1: fz: the cell is empty. Write a number"}},
    {"DashedLoad", "fz,dz\n-,1\n", {":2:1: fz: '-' is not a number"}},
    {"NothingMeasured",
     "fz,dx,dz\n1,,\n",
     {":2:3: dx: the reading has no displacement at all. Write what was measured"}},
    {"NothingAnywhere", "fz,dz\n1,-\n2,n/a\n", {"no row has a displacement. At least one reading"}},
    {"ShortRow",
     "fz,dx,dz\n1,2\n",
     {":2: dz: this row has 2 cells, the header has 3: '1,2'. Give one cell"}},
    {"LongRow", "fz,dz\n1,2\n1,2,3\n", {":3: this row has 3 cells, the header has 2"}},
    {"OpenQuote", "fz,dz\n\"1,2\n", {":2:1: the quote that starts here is not closed"}},
    {"TextAfterQuote", "fz,dz\n\"1\"a,2\n", {":2:4: text follows the quote"}},
    {"SameName", "fz,dz,fz\n1,2,3\n", {":1:7: two columns are named 'fz'. Give each column"}},
    {"SameMeaning",
     "fz,Fz [kN],dz\n1,2,3\n",
     {":1:4: Fz [kN]: the columns 'Fz [kN]' and 'fz' mean the same: fz. Remove one"}},
    {"NoName", "fz,,dz\n1,2,3\n", {":1:4: column 2 has no name. Name every column"}},
    {"NoRows", "fz,dz\n", {"the table has a header but no row. Give one row"}},
    {"NoTable", "\n# nothing\n", {"holds no table. Give a header line"}},
    {"NoNames",
     "0,30,50,46\n0,30,100,92\n",
     {":1: numbers stand where the columns should have their names. Write a line of names"}},
    {"Summary",
     "no,fz,dz\n1,1,1\n2,2,2\nMean,1.5,1.5\nStd:,,0.7\n",
     {"line 4:1  'Mean' looks like a summary of other rows, not like a reading (and on line 5)",
      "Remove the row"}},
    {"QuoteAmongOthers",
     "fz,dz\n1,2,3\n1,abc\n1,\"2\n",
     {"3 things to repair", "line 2    this row has 3 cells", "line 3:3  dz: 'abc' is not a number",
      "line 4:3  the quote that starts here is not closed"}},
    {"ForceWithoutAxis",
     "Load Cell [kN],dz\n1,1\n",
     {"there is no column of load", "if it is 'Load Cell [kN]', say 'columns: {Load Cell: fz}'"}},
    {"NoLoad", "A1,A2,dz\n0,0,1\n", {":1: there is no column of load", "Name at least one of fx"}},
    {"NoDisplacement",
     "A1,A2,fz\n0,0,1\n",
     {":1: there is no column of displacement", "Name at least one of dx"}},
    {"LoadWithoutUnit",
     "Kraft X,dz\n1,2\n",
     {":1:1: Kraft X: 'Kraft X' has no unit. Write 'Kraft X [N]', or 'columns: {Kraft X: fx "
      "[N]}'"}},
    {"GaugeWithoutUnit",
     "fz,Deflection z\n1,2\n",
     {":1:4: Deflection z: 'Deflection z' has no unit. Write 'Deflection z [mm]', or 'columns: "
      "{Deflection z: dz [mm]}'"}},
    {"UnitByUnderscore",
     "fz,dz_um\n1,2\n",
     {":1:4: dz_um: 'dz_um' is not known as dz. Say 'columns: {dz_um: dz [um]}'"}},
    {"UnknownUnit",
     "fz [Newton],dz\n1,2\n",
     {":1:1: fz [Newton]: unit 'Newton': 'Newton' is not a known unit"}},
    {"WrongUnit",
     "fz [mm],dz\n1,2\n",
     {":1:1: fz [mm]: 'mm' is in m: expected a force", "Write the unit in which"}},
    {"LengthOfTurn", "fz,rz [mm]\n1,2\n", {":1:4: rz [mm]: 'mm' is in m: expected an angle"}},
    {"MomentInNewton",
     "mz [N],rz\n1,2\n",
     {":1:1: mz [N]: 'N' is in N: expected a moment"},
     "wrench_point: reference\n"},
    {"MomentWithoutPoint", "mz,rz\n1,1\n", {":1:1: mz: moments are given without the point"}},
    {"HalfAPoint",
     "fz,px,py,dz\n1,0,0,1\n",
     {":1: pz: the column 'pz' is missing: px, py and pz go together"}},
    {"HalfAPose",
     "x,y,fz,dz\n0,0,1,1\n",
     {":1: z: the column 'z' is missing: x, y and z go together. Add it"}},
    {"AnglesAlone",
     "roll,pitch,yaw,fz,dz\n0,0,0,1,1\n",
     {"roll, pitch, yaw need a position as well"}},
    {"OneJointOfTwo",
     "A1,fz,dz\n0,1,1\n",
     {":1: A2: the actuated joint 'A2' has no column, but others have"}},
    {"MisspeltJoint",
     "A1,A22,fz,dz\n0,0,1,1\n",
     {"the actuated joint 'A2' has no column, but others have. Rename the column 'A22'"}},
    {"PoseTwice", "A1,A2,x,y,z,fz,dz\n0,0,1,1,1,1,1\n", {":1:7: x: the posture is given twice"}},
    {"MeasuredPlace",
     "A1,A2,x,y,z,fz\n0,0,1,1,1,1\n",
     {"If the position was measured, say 'columns: {x: dx, y: dy, z: dz}'"}},
    {"SameId",
     "id,fz,dz\na,1,1\nb,1,1\na,2,1\n",
     {":4:1: id: the id 'a' is already used on line 2. Give each row"}},
    {"EmptyId", "id,fz,dz\n,1,1\n", {":2:1: id: the id is empty"}},
    {"UnknownDirection",
     "direction,fz,dz\nup,1,1\n",
     {":2:1: direction: 'up' is not a direction of load. Write loading or unloading"}},
    {"UnknownRole",
     "role,fz,dz\ntrain,1,1\n",
     {":2:1: role: 'train' is not a role. Write fit, select or confirm"}},
    {"UnknownInstrument",
     "instrument,fz,dz\ngague,1,1\n",
     {":2:1: instrument: the instrument 'gague' is not described. Did you mean 'gauge'?"},
     "instruments: {gauge: {translation: 2 um}}\n"},
    {"UnknownMask",
     "fz,dz,mask\n1,1,yes\n",
     {":2:5: mask: 'yes' is neither 0 nor 1. Write 1 to leave"}},
    {"MaskWithoutReason",
     "fz,dz,mask\n1,1,1\n",
     {":2:5: mask: the reading is masked without a reason. Say why"}},
    {"AllMasked",
     "fz,dz,mask,mask_reason\n1,1,1,slipped\n",
     {":2:5: mask: every reading is masked"}},
    {"ZeroSigma", "fz,dz,sigma\n1,1,0\n", {":2:5: sigma: '0' is not positive"}},
    {"SigmaForSome",
     "fz,dz,sigma\n1,1,0.1\n2,1,\n",
     {":3:3: dz: this value has no standard deviation, but others have"}},
    {"ImpossibleCorrelation",
     "fz,dx,dz,sigma,corr_dx_dz\n1,1,1,1,1.5\n",
     {":2:9: corr_dx_dz: with '1.5' these correlations are not possible together"}},
    {"TimeBackwards",
     "cycle,time,fz,dz\na,2,1,1\na,1,1,1\n",
     {":3:3: time: time runs backwards in this cycle: '1' comes after '2' of line 2"}},
    {"AmericanDate",
     "time,fz,dz\n5/3/2026 14:22,1,1\n",
     {":2:1: time: '5/3/2026 14:22' may be one day or another. Write dates as 2026-05-03"}},
    {"TimeOfAnotherKind",
     "time,fz,dz\n14:22:05,1,1\n2026-05-03T14:22:06,1,1\n",
     {":3:1: time: '2026-05-03T14:22:06' is not a time like that of the first row"}},
    {"NoSuchTime",
     "time,fz,dz\n14:22:05,1,1\n14:75:00,1,1\n",
     {":3:1: time: '14:75:00' is not a time like"}},
    {"StatedColumnMissing",
     "fz,dz\n1,1\n",
     {"campaign.yaml:6: columns.Krat: the readings have no column 'Krat'"},
     "columns: {Krat: fx [N]}\n"},
    {"StatedMeaningUnknown",
     "Pull,dz\n1,1\n",
     {"columns.Pull: 'fxx' is neither a quantity nor a joint", "Did you mean 'fx'?"},
     "columns: {Pull: fxx [N]}\n"},
    {"StatedTwice",
     "a,b,dz\n1,1,1\n",
     {"columns.b: 'a' is fx already. Give each meaning to one column"},
     "columns: {a: fx [N], b: fx [N]}\n"},
    {"StatedUnitUnknown",
     "Pull,dz\n1,1\n",
     {":1:1: Pull: unit 'Nn'"},
     "columns: {Pull: fx [Nn]}\n"},
    // Sensors, weights and cylinders.
    {"SensorWithoutColumn",
     "fz,dz\n1,1\n",
     {":1: dial: the sensor 'dial' has no column. Add it, say which it is under 'columns'"},
     "sensors: {dial: {kind: gauge, on: A2, direction: [0, 0, 1]}}\n"},
    {"SensorInAnotherUnit",
     "fz,dial [urad]\n1,1\n",
     {":1:4: dial [urad]: 'urad' is", "expected a length", "Write the unit in which"},
     "sensors: {dial: {kind: gauge, on: A2, direction: [0, 0, 1]}}\n"},
    {"WeightWithoutColumn",
     "fz,dz\n1,1\n",
     {":1: hook: the weight 'hook' has no column. Add it", "or remove the weight"},
     "weights: {hook: {on: A2}}\n"},
    {"NegativeWeight",
     "hook,dz\n-1,1\n",
     {":2:1: hook: -1 is less than no weight. Write how much hangs there"},
     "weights: {hook: {on: A2}}\n"},
    {"CylinderWithoutColumn",
     "fz,dz\n1,1\n",
     {":1: push: the cylinder 'push' has no column. Add it", "or remove the cylinder"},
     "cylinders: {push: {on: A2, from: base}}\n"},
    {"CylinderOfNoLength",
     "push,dz\n1,1\n",
     {":2:1: push: the ends of 'push' are at one point. Correct 'at' and 'from'"},
     "cylinders: {push: {on: A2, from: A2}}\n"},
    {"SensorAndWeightCells",
     "hook,dial,dz\nx,1,1\n-2,y,1\n",
     {"3 things to repair", "line 2:1  hook: 'x' is not a number",
      "line 3:1  hook: -2 is less than no weight", "line 3:4  dial: 'y' is not a number"},
     "weights: {hook: {on: A2}}\nsensors: {dial: {kind: gauge, on: A2, direction: [0, 0, 1]}}\n"},
    // Several at once, in the order of their places.
    {"NameAndCells",
     "Stiffness test\nKraft X;dz [mm];id\n1;0,5;a\nx;0,25;a\n2;0.75;b\n",
     {"4 things to repair before anything can be computed", "line 2:1  'Kraft X' has no unit",
      "line 4:1  Kraft X: 'x' is not a number", "line 4:8  the id 'a' is already used on line 3",
      "line 5:3  dz [mm]: '0.75' is not a number"}},
    {"RowsAndCells",
     "fz,dz,mask\n1,2\n3,oops,\n4,5,maybe\n",
     {"3 things to repair", "line 2 ", "this row has 2 cells, the header has 3",
      "line 3:3  dz: 'oops' is not a number", "line 4:5  mask: 'maybe' is neither 0 nor 1"}},
    {"ManyOfOneKind",
     "fz,dz\n1,a\n1,b\n1,c\n1,d\n1,e\n1,f\n1,g\n",
     {"1 thing to repair", "'a' is not a number (and on lines 3, 4, 5, 6 and 2 more)"}},
    {"TableAndCampaign",
     "fz,dz\n1,oops\n",
     {"2 things to repair",
      "campaign.yaml line 6  columns.Gauge: the readings have no column 'Gauge'", "line 2:3",
      "dz: 'oops' is not a number"},
     "columns: {Gauge: dx}\n"},
};

INSTANTIATE_TEST_SUITE_P(All, MalformedTable, testing::ValuesIn(tables),
                         [](const auto& table) { return table.param.name; });

}  // namespace
}  // namespace kinetostat::calibration::malformed_table_test
