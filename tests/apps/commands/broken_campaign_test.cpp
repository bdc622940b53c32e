// Campaigns that are wrong in one way each, given to the program: the message names file, line,
// column and value and says what to do; nothing is left behind.
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/run_program.h"

namespace kinetostat::broken_campaign_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string head =
    "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, angle: deg, time: s}\n"
    "displacement: difference\nreadings: readings.csv\n";

std::string without(const std::string& line) {
  std::string text = head;
  const std::size_t begin = text.find(line);
  return text.erase(begin, text.find('\n', begin) + 1 - begin);
}

const std::string pose = "x,y,z,fx,dx\n";

struct Broken {
  std::string name, yaml, csv;
  std::string message;  // from the place to the cure
};

class BrokenCampaign : public testing::TestWithParam<Broken> {};

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

TEST_P(BrokenCampaign, IsRefusedWithPlaceValueAndCure) {
  const std::filesystem::path folder = working_folder() / ("broken_" + GetParam().name);
  std::filesystem::create_directory(folder);
  write(folder / "readings.csv", GetParam().csv);
  write(folder / "campaign.yaml", GetParam().yaml);
  const std::string name = folder.filename().string();
  const Outcome outcome =
      kinetostat("compare data/robots/orthoglide.yaml " + name + "/campaign.yaml --json " + name +
                 "/out.json --csv " + name + "/out.csv");
  EXPECT_EQ(outcome.code, 3) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().message));
  EXPECT_THAT(outcome.err, testing::EndsWith("\n"));
  for (const char* file : {"out.json", "out.csv"})
    EXPECT_FALSE(std::filesystem::exists(folder / file)) << file;
}

INSTANTIATE_TEST_SUITE_P(
    All, BrokenCampaign,
    testing::Values(
        Broken{"NoUnits", without("units"), pose + "0,0,0,1,1\n",
               "campaign.yaml:1: the key 'units' is missing"},
        Broken{"NoAngleUnit",
               "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\n"
               "displacement: difference\nreadings: readings.csv\n",
               "x,y,z,fx,rx\n0,0,0,1,1\n",
               "campaign.yaml:3: units.angle: no unit of angle is stated, but the readings have "
               "the column 'rx'. "
               "Write 'angle: deg' under 'units'"},
        Broken{"NoTimeUnit",
               "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\n"
               "displacement: difference\nreadings: readings.csv\n",
               "x,y,z,time,fx,dx\n0,0,0,1,1,1\n",
               "campaign.yaml:3: units.time: no unit of time is stated, but the readings have the "
               "column "
               "'time'. Write 'time: s' under 'units'"},
        Broken{"NoiseWithoutUnit", head + "noise: {translation: 15}\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: noise.translation: "},
        Broken{"NegativeNoise", head + "noise: {translation: -15 um}\n", pose + "0,0,0,1,1\n",
               "'-15 um' is not positive. Give the standard deviation"},
        Broken{"MisspeltKey", head + "nose: {translation: 15 um}\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: nose: the key 'nose' is not known here. Did you mean 'noise'?"},
        Broken{"UnknownKind", without("displacement") + "displacement: relative\n",
               pose + "0,0,0,1,1\n", "displacement: 'relative' is not one of difference, absolute"},
        Broken{"NoReadingsFile", without("readings") + "readings: reading.csv\n",
               pose + "0,0,0,1,1\n", "reading.csv' does not exist. Did you mean 'readings.csv'?"},
        Broken{"NotANumber", head, pose + "0,0,0,1,0.5\n0,0,0,12 N,0.5\n",
               "readings.csv:3:7: fx: '12 N' is not a number. Write the number alone"},
        Broken{"EmptyLoad", head, pose + "0,0,0,,0.5\n",
               "readings.csv:2:7: fx: the cell is empty. Write a number"},
        Broken{"DuplicateId", head, "id," + pose + "a,0,0,0,1,1\nb,0,0,0,1,1\na,0,0,0,2,1\n",
               "readings.csv:4:1: id: the id 'a' is already used on line 2. Give each row"},
        Broken{"EmptyId", head, "id," + pose + ",0,0,0,1,1\n",
               "readings.csv:2:1: id: the id is empty"},
        Broken{"NothingMeasured", head, pose + "0,0,0,1,\n",
               "readings.csv:2:9: dx: the reading has no displacement at all. Write what was"},
        Broken{"NoDisplacementColumn", head, "x,y,z,fx\n0,0,0,1\n",
               "readings.csv:1: there is no column of displacement. Name at least one of dx"},
        Broken{"NoLoadColumn", head, "x,y,z,dx\n0,0,0,1\n",
               "readings.csv:1: there is no column of load"},
        Broken{
            "MomentWithoutPoint", head, "x,y,z,mz,rz\n0,0,0,1,1\n",
            "readings.csv:1:7: mz: moments are given without the point that they are taken about. "
            "Add the columns px, py, pz, or 'wrench_point: reference'"},
        Broken{"HalfAPoint", head, "x,y,z,fx,px,py,dx\n0,0,0,1,0,0,1\n",
               "readings.csv:1: pz: the column 'pz' is missing: px, py and pz go together"},
        Broken{"HalfAPose", head, "x,y,fx,dx\n0,0,1,1\n",
               "readings.csv:1: z: the column 'z' is missing: x, y and z go together"},
        Broken{"MissingJoint", head, "x.rho,y.rho,fx,dx\n-450,-450,1,1\n",
               "readings.csv:1: z.rho: the actuated joint 'z.rho' has no column"},
        Broken{"MisspeltJoint", head, "x.rho,y.rho,z.rh,fx,dx\n-450,-450,-450,1,1\n",
               "the actuated joint 'z.rho' has no column, but others have. Rename the column "
               "'z.rh' if that is it"},
        Broken{"PoseTwice", head, "x,y,z,x.rho,y.rho,z.rho,fx,dx\n0,0,0,1,1,1,1,1\n",
               "readings.csv:1:1: x: the posture is given twice: by x, y, z and by joint "
               "coordinates. Keep"},
        Broken{"UnknownUnitInHeader", head, "x,y,z,Fx [Newton],dx\n0,0,0,1,1\n",
               "readings.csv:1:7: Fx [Newton]: unit 'Newton': 'Newton' is not a known unit"},
        Broken{"TimeRunsBackwards", head,
               "cycle,time," + pose + "a,1,0,0,0,1,1\na,5,0,0,0,1,1\na,4,0,0,0,1,1\n",
               "readings.csv:4:3: time: time runs backwards in this cycle: '4' comes after '5' of "
               "line 3. Order the rows by time"},
        Broken{"SigmaForSomeOnly", head, "x,y,z,fx,dx,sigma\n0,0,0,1,1,0.01\n0,0,0,2,1,\n",
               "readings.csv:3:9: dx: this value has no standard deviation, but others have. State "
               "it under 'noise' in the campaign file or in a column sigma_dx"},
        Broken{"ZeroSigma", head, "x,y,z,fx,dx,sigma\n0,0,0,1,1,0\n",
               "readings.csv:2:11: sigma: '0' is not positive"},
        Broken{"MaskWithoutReason", head, pose.substr(0, pose.size() - 1) + ",mask\n0,0,0,1,1,1\n",
               "readings.csv:2:11: mask: the reading is masked without a reason. Say why in"},
        Broken{"WrongMask", head, "x,y,z,fx,dx,mask\n0,0,0,1,1,maybe\n",
               "readings.csv:2:11: mask: 'maybe' is neither 0 nor 1. Write 1 to leave"},
        Broken{
            "AllMasked", head, "x,y,z,fx,dx,mask,mask_reason\n0,0,0,1,1,1,slipped\n",
            "readings.csv:2:11: mask: every reading is masked. At least one reading must be used"},
        Broken{"WrongDirection", head, "x,y,z,fx,dx,direction\n0,0,0,1,1,up\n",
               "readings.csv:2:11: direction: 'up' is not a direction of load. Write loading or"},
        Broken{"PoseOutOfReach", head, pose + "0,0,0,1,1\n0,0,900,1,1\n",
               "readings.csv:3: the posture of reading '2' is out of reach: chain "},
        Broken{"RaggedRow", head, pose + "0,0,0,1\n",
               "readings.csv:2: dx: this row has 4 cells, the header has 5"},
        Broken{"UnknownRole", head, "role,x,y,z,fx,dx\nverify,0,0,0,1,1\n",
               "readings.csv:2:1: role: 'verify' is not a role. Write fit, select or confirm"},
        Broken{"RoleOfNoSession", head + "roles: {morning: confirm}\n",
               "session,x,y,z,fx,dx\nmornings,0,0,0,1,1\n",
               "campaign.yaml:6: roles.morning: no reading belongs to a session 'morning'. Did you "
               "mean 'mornings'?"},
        Broken{"NothingToFit", head + "roles: {a: confirm}\n", "session,x,y,z,fx,dx\na,0,0,0,1,1\n",
               "campaign.yaml:6: roles: no reading is left to fit by"},
        Broken{"UnknownInstrument", head + "instruments: {tracker: {translation: 10 um}}\n",
               "instrument,x,y,z,fx,dx\ntraker,0,0,0,1,1\n",
               "readings.csv:2:1: instrument: the instrument 'traker' is not described. Did you "
               "mean 'tracker'?"},
        Broken{"NoiseTwice",
               head + "noise: {translation: 1 um}\ninstruments: {gauge: {translation: 2 um}}\n"
                      "instrument: gauge\n",
               pose + "0,0,0,1,1\n",
               "campaign.yaml:8: instrument: 'noise' and 'instrument' both say how exact the "
               "readings are. Keep one"},
        Broken{"DateOfAnotherOrder", head + "date: 1.3.2026\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: date: '1.3.2026' is not a date of ISO 8601. Write 2026-03-01"},
        Broken{"DateOfNoDay", head + "date: 2026-02-30\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: date: '2026-02-30' is not a date of ISO 8601. Write year, month"},
        Broken{"OperatorOfNothing", head + "operator: ' '\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: operator: nothing is stated. Write it behind the key"},
        Broken{"ImpossibleCorrelation", head,
               "x,y,z,fx,dx,dy,sigma,corr_dx_dy\n0,0,0,1,1,1,1,1.2\n",
               "readings.csv:2:15: corr_dx_dy: with '1.2' these correlations are not possible "
               "together. Each lies between -1 and 1"},
        Broken{"UnknownFrame", head + "wrench_frame: tabel\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: wrench_frame: 'tabel' is not one of base, platform"},
        Broken{
            "AbsoluteInMovingFrame",
            without("displacement") + "displacement: absolute\ndisplacement_frame: platform\n",
            pose + "0,0,0,1,1\n",
            "campaign.yaml:6: displacement_frame: absolute poses cannot be given in a frame that "
            "moves with the platform. Name a frame on the base"},
        Broken{"FrameWithoutBody", head + "frames: {cell: {pose: [0, 0, 0]}}\n",
               pose + "0,0,0,1,1\n", "campaign.yaml:6: frames.cell: the key 'on' is missing"},
        Broken{"RedescribedBase", head + "frames: {base: {on: base, pose: [0, 0, 0]}}\n",
               pose + "0,0,0,1,1\n",
               "campaign.yaml:6: frames.base: the frame 'base' needs no description. Choose"}),
    [](const auto& broken) { return broken.param.name; });

}  // namespace
}  // namespace kinetostat::broken_campaign_test
