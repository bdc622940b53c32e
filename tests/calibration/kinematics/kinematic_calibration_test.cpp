// Geometric errors are recovered from poses: those that were there, as exactly as is stated, and
// those that kinematics or poses do not determine are named.
#include "kinetostat/calibration/kinematics/kinematic_calibration.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"
#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

#include "calibration/laboratory.h"
#include "calibration/synthetic.h"

namespace kinetostat::calibration::kinematic_calibration_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Contains;
using testing::HasSubstr;

constexpr double right = 1.5707963267948966;

// A Denavit-Hartenberg table with two parallel axes and three that meet.
struct Dh {
  double a = 0, alpha = 0, d = 0, offset = 0;
};
const std::vector<Dh> table = {{0, right, 0.1273},   {-0.612, 0, 0},      {-0.5723, 0, 0},
                               {0, right, 0.163941}, {0, -right, 0.1157}, {0, 0, 0.0922}};

// A target beside the axis of the last joint, in the frame of the flange [mm].
constexpr char beside_axis[] = "    - tool: [30, 20, 50]\n";

std::string arm(const std::string& more = "", const std::string& tool = "") {
  std::string links = "links:\n", chain = "chain_types:\n  arm:\n";
  for (std::size_t i = 0; i < table.size(); ++i) {
    links += fmt::format("  l{}: {{rigid: {{point: [{}, 0, {}], rotation_vector: [{}, 0, 0]}}}}\n",
                         i + 1, 1e3 * table[i].a, 1e3 * table[i].d, table[i].alpha);
    chain += fmt::format(
        "    - actuator: {{name: q{0}, axis: Rz, stiffness: 1e5 N m/rad}}\n    - link: l{0}\n",
        i + 1);
  }
  return "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: rad}\n" + links + chain +
         tool + "manipulator: {chain: arm}\n" + more;
}

constexpr char scara[] = R"(kinetostat: 1
name: scara
units: {length: mm, force: N, angle: rad}
links:
  column: {rigid: [0, 0, 300]}
  upper: {rigid: [350, 0, 0]}
  lower: {rigid: [250, 0, 0]}
chain_types:
  arm:
    - link: column
    - actuator: {name: q1, axis: Rz, stiffness: 1e5 N m/rad, range: [-2, 2]}
    - link: upper
    - actuator: {name: q2, axis: Rz, stiffness: 1e5 N m/rad, range: [-2, 2]}
    - link: lower
    - actuator: {name: z, axis: Tz, stiffness: 1e6 N/m, range: [-200, 0]}
    - actuator: {name: q4, axis: Rz, stiffness: 1e4 N m/rad, range: [-3, 3]}
manipulator: {chain: arm}
)";

double uniform(std::mt19937_64& engine, double from, double to) {
  return from + (to - from) * static_cast<double>(engine() >> 11) * 0x1p-53;
}

std::vector<VectorXd> random_postures(Index joints, int count, unsigned seed, double range = 2) {
  std::mt19937_64 engine(seed);
  std::vector<VectorXd> postures;
  for (int i = 0; i < count; ++i) {
    postures.emplace_back(joints);
    for (double& q : postures.back()) q = uniform(engine, -range, range);
  }
  return postures;
}

std::string plan(const std::vector<std::string>& names, const std::vector<VectorXd>& postures) {
  std::string csv = fmt::format("{}\n", fmt::join(names, ","));
  for (const VectorXd& q : postures) csv += fmt::format("{}\n", fmt::join(q, ","));
  return csv;
}

const std::vector<std::string> six = {"q1", "q2", "q3", "q4", "q5", "q6"};

// Reads poses.
class PoseLaboratory : public test::Laboratory {
 public:
  explicit PoseLaboratory(const std::string& robot, unsigned seed = 1) : Laboratory(robot) {
    options().displacement = DisplacementKind::absolute;
    options().components.fill(true);
    options().translation_noise = 1e-5;
    options().rotation_noise = 2e-5;
    options().seed = seed;
  }
};

KinematicCalibration calibrated(const vjm::Robot& robot, const Campaign& campaign,
                                const KinematicOptions& options = {}) {
  common::Progress silent;
  return calibrate_kinematics(robot, campaign, options, 2, silent);
}

std::vector<std::string> left_out(const KinematicCalibration& c, LeftOut why) {
  std::vector<std::string> phrases;
  for (const LeftOutGeometry& out : c.left_out)
    if (out.why == why)
      phrases.push_back(fmt::format("{}: {}", out.what.phrase(), fmt::join(out.like, ", ")));
  return phrases;
}

// --- how many there are
// ---------------------------------------------------------------------------

// 4 for each joint that turns, 2 for each that slides, and 6: Everett, Driels and Mooring 1987. And
// the scale of each that slides.
TEST(GeometricParameters, AreAsManyAsACompleteModelHas) {
  const auto count = [](const std::string& robot, const std::vector<std::string>& joints) {
    PoseLaboratory lab(robot);
    const Campaign campaign =
        lab.measure(plan(joints, random_postures(static_cast<Index>(joints.size()), 60, 3, 1.5)));
    common::Progress silent;
    const KinematicCalibration c = calibrated(lab.robot(), campaign, {.folds = 0});
    EXPECT_THAT(left_out(c, LeftOut::unseen), testing::IsEmpty());
    EXPECT_THAT(left_out(c, LeftOut::confounded), testing::IsEmpty());
    return std::ssize(c.geometry);
  };
  EXPECT_EQ(count(arm(), six), 4 * 6 + 6);
  std::string metres = scara;  // a slide of 1.5 m would not be
  EXPECT_EQ(count(metres.replace(metres.find("length: mm"), 10, "length: m"),
                  {"q1", "q2", "arm.z", "q4"}),
            4 * 3 + (2 + 1) + 6);
}

TEST(GeometricParameters, ClassicalRedundanciesAreNamed) {
  PoseLaboratory lab(arm());
  const Campaign campaign = lab.measure(plan(six, random_postures(6, 60, 3)));
  const KinematicCalibration c = calibrated(lab.robot(), campaign, {.folds = 0});
  const std::vector<std::string> redundant = left_out(c, LeftOut::redundant);
  // The first joint and the base, the last joint and the tool, shifts along parallel axes.
  EXPECT_THAT(redundant, Contains("the offset of q1: the turn of the base about z"));
  EXPECT_THAT(redundant, Contains("the offset of q6: the turn of the tool about z"));
  EXPECT_THAT(redundant, Contains("the shift behind q3 along z: the shift behind q2 along z")
                             .Times(0));  // as that itself is like one before:
  EXPECT_THAT(redundant, Contains(HasSubstr("the shift behind q2 along z: the shift behind q1")));
  EXPECT_THAT(redundant, Contains(HasSubstr("the shift behind q3 along z: the shift behind q1")));
  // Without the frame of the instrument the base is that frame.
  const KinematicCalibration unknown = calibrated(
      lab.robot(), lab.measure(plan(six, random_postures(6, 60, 4)), "session_frame: estimate\n"),
      {.folds = 0});
  EXPECT_EQ(std::ssize(unknown.geometry), 4 * 6);
  EXPECT_THAT(left_out(unknown, LeftOut::redundant),
              Contains("the offset of q1: the frame of the readings"));
}

TEST(GeometricParameters, PositionsAloneDoNotShowHowTheToolIsTurned) {
  PoseLaboratory lab(arm("", beside_axis));
  lab.options().components = {true, true, true, false, false, false};
  const KinematicCalibration c =
      calibrated(lab.robot(), lab.measure(plan(six, random_postures(6, 80, 5))), {.folds = 0});
  EXPECT_EQ(std::ssize(c.geometry), 27);
  EXPECT_THAT(left_out(c, LeftOut::unseen),
              testing::UnorderedElementsAre(
                  "the turn of the tool about x: ", "the turn of the tool about y: ",
                  "the turn of the tool about z: "));
}

// A joint that does not move cannot be distinguished from what is before and behind it.
TEST(GeometricParameters, AJointAtRestHidesWhatIsBehindIt) {
  PoseLaboratory lab(arm());
  std::vector<VectorXd> postures = random_postures(6, 80, 6);
  for (VectorXd& q : postures) q[4] = 0.4;
  const KinematicCalibration c =
      calibrated(lab.robot(), lab.measure(plan(six, postures)), {.folds = 0});
  EXPECT_LT(std::ssize(c.geometry), 30);
  EXPECT_THAT(left_out(c, LeftOut::confounded), Contains(HasSubstr("behind q5")));
}

// --- their derivatives
// -----------------------------------------------------------------------------

TEST(GeometricParameters, DerivativesAreThoseOfDifferences) {
  PoseLaboratory lab(arm());
  const Campaign campaign =
      lab.measure("q1,q2,q3,q4,q5,q6,fx,fz\n0.3,-0.7,0.9,0.4,0.8,-0.5,80,-120\n");
  const vjm::Manipulator& bare = lab.robot().without_effects();
  const GeometricModel model = geometric_model(lab.robot(), {1e-3, 1e-3});
  const std::vector<Parameter> parameters = fit_parameters(model, bare);
  common::Progress silent;
  const Predictor predictor(bare, model.effects, campaign, 1, silent);
  Normal normal(7);
  VectorXd at(static_cast<Index>(parameters.size()));
  for (double& value : at) value = 2e-3 * normal();
  const MatrixXd exact = predictor.predict(parameters, at, true, silent).derivatives[0];
  constexpr double step = 1e-5;
  for (Index k = 0; k < at.size(); ++k) {
    VectorXd up = at, down = at;
    up[k] += step;
    down[k] -= step;
    const VectorXd difference =
        (predictor.predict(parameters, up, false, silent).displacement[0] -
         predictor.predict(parameters, down, false, silent).displacement[0]) /
        (2 * step);
    EXPECT_LT((exact.col(k) - difference).cwiseAbs().maxCoeff(), 1e-7)
        << model.parameters[static_cast<std::size_t>(k)].phrase();
  }
}

// --- recovered
// -------------------------------------------------------------------------------------

// The squared distance of what is found from what is there, in its own covariance, is chi-square.
TEST(KinematicCalibration, RecoversErrorsAsExactlyAsItSays) {
  const std::vector<VectorXd> postures = random_postures(6, 60, 11);
  PoseLaboratory first(arm());
  const KinematicCalibration at_nominal =
      calibrated(first.robot(), first.measure(plan(six, postures)), {.folds = 0});
  const auto count = std::ssize(at_nominal.geometry);
  double sum = 0;
  int beyond = 0;
  constexpr int seeds = 20;
  for (int seed = 1; seed <= seeds; ++seed) {
    PoseLaboratory lab(arm(), static_cast<unsigned>(100 * seed));
    Normal normal(static_cast<std::uint64_t>(seed));
    std::vector<vjm::Effect> truth = at_nominal.effects;
    for (vjm::Effect& effect : truth) effect.values.setZero();
    for (const CalibratedGeometry& g : at_nominal.geometry)
      truth[g.what.effect].values[g.what.component] = 5e-4 * normal();
    lab.options().hidden = truth;
    const KinematicCalibration c =
        calibrated(lab.robot(), lab.measure(plan(six, postures)), {.folds = 0});
    ASSERT_EQ(std::ssize(c.geometry), count);
    VectorXd off(count);
    for (Index k = 0; k < count; ++k) {
      const CalibratedGeometry& g = c.geometry[static_cast<std::size_t>(k)];
      off[k] = (g.value - truth[g.what.effect].values[g.what.component]) / g.deviation;
      beyond += std::abs(off[k]) > 1.96;
    }
    sum += off.dot(c.correlation.topLeftCorner(count, count).ldlt().solve(off));
  }
  const double p = chance_of_larger_chi_square(sum, static_cast<double>(seeds * count));
  EXPECT_GT(p, 1e-3) << sum;
  EXPECT_LT(p, 1 - 1e-3) << sum;
  EXPECT_NEAR(beyond / static_cast<double>(seeds * count), 0.05, 0.03);
}

TEST(KinematicCalibration, PredictsPosesThatItHasNotSeenToTheNoise) {
  PoseLaboratory lab(arm());
  lab.hide("geometric_error", "q2", "x=0.4 mm,rx=0.6 mrad,rz=-1.5 mrad");
  lab.hide("geometric_error", "q4", "y=-0.3 mm,rz=2 mrad");
  const KinematicCalibration c =
      calibrated(lab.robot(), lab.measure(plan(six, random_postures(6, 80, 12))));
  EXPECT_EQ(c.after().name, "links");
  ASSERT_TRUE(c.after().held_out);
  // 480 values, 30 unknowns: sqrt(1 + 2 * 30 / 480) at most, and 3 % of chance.
  EXPECT_NEAR(c.after().held_out->whitened, 1.05, 0.08);
  EXPECT_GT(c.before().held_out->whitened, 20);
  EXPECT_NEAR(c.residual_ratio, 1, 0.1);
  for (const CalibratedGeometry& g : c.geometry) {
    if (g.what.phrase() != "the offset of q4") continue;
    EXPECT_NEAR(g.value, 2e-3, 4 * g.deviation);
  }
}

TEST(KinematicCalibration, FindsTheLeadOfAScrew) {
  PoseLaboratory lab(scara);
  vjm::Effect lead;
  lead.kind = vjm::effect_kind("transmission_ratio", lab.robot().kinds());
  lead.at = "arm.z";
  lead.sites = {{0, "z"}};
  lead.values = VectorXd::Constant(1, 8e-4);
  lab.options().hidden = {lead};
  std::vector<VectorXd> postures = random_postures(4, 60, 21, 1.5);
  for (VectorXd& q : postures) q[2] = 60 * q[2] - 100;  // [mm]
  const KinematicCalibration c =
      calibrated(lab.robot(), lab.measure(plan({"q1", "q2", "arm.z", "q4"}, postures)));
  EXPECT_EQ(c.stages[c.taken].name, "drives");
  const auto scale = std::find_if(c.geometry.begin(), c.geometry.end(), [](const auto& g) {
    return g.what.group == GeometryGroup::drive;
  });
  ASSERT_NE(scale, c.geometry.end());
  EXPECT_EQ(scale->what.phrase(), "the scale of z");
  EXPECT_NEAR(scale->value, 8e-4, 3 * scale->deviation);
  EXPECT_LT(scale->deviation, 8e-5);
}

TEST(KinematicCalibration, LeavesASoundRobotAlone) {
  PoseLaboratory lab(arm());
  const KinematicCalibration c =
      calibrated(lab.robot(), lab.measure(plan(six, random_postures(6, 80, 13))));
  EXPECT_EQ(c.after().name, "nominal");
  EXPECT_TRUE(c.geometry.empty());
}

// Stiffnesses that the file declares uncertain are fitted beside it, where loads show them.
TEST(KinematicCalibration, FitsStiffnessesBesideTheGeometry) {
  const std::string softer = arm();
  PoseLaboratory lab(
      arm("uncertain: [{stiffness: q2}, {stiffness: q3}]\n"
          "effects:\n  - {effect: joint_compliance, at: q2, c: 1.0e-7 rad/(N m)}\n"));
  lab.hide("joint_compliance", "q3", "1.0e-5 rad/(N m)");  // half as stiff
  lab.hide("geometric_error", "q2", "rz=1 mrad");
  std::string csv = "q1,q2,q3,q4,q5,q6,fz\n";
  for (const VectorXd& q : random_postures(6, 60, 14))
    for (const double load : {0.0, -200.0}) csv += fmt::format("{},{}\n", fmt::join(q, ","), load);
  const KinematicCalibration c = calibrated(lab.robot(), lab.measure(csv));
  ASSERT_EQ(c.others.size(), 2u);
  EXPECT_NEAR(std::exp(c.others[1].value), 0.5, 4 * 0.5 * c.others[1].standard_error);
  EXPECT_NEAR(c.residual_ratio, 1, 0.1);
}

TEST(KinematicCalibration, RobustFitsStandFarReadings) {
  PoseLaboratory lab(arm());
  lab.hide("geometric_error", "q3", "rz=2 mrad");
  Campaign campaign = lab.measure(plan(six, random_postures(6, 80, 15)));
  for (std::size_t i = 0; i < campaign.readings.size(); i += 20)
    campaign.readings[i].displacement[0] += 0.02;
  const auto offset_of = [&](Loss loss) {
    const KinematicCalibration c = calibrated(lab.robot(), campaign, {.folds = 0, .loss = loss});
    for (const CalibratedGeometry& g : c.geometry)
      if (g.what.phrase() == "the offset of q3") return g.value;
    return 0.0;
  };
  EXPECT_NEAR(offset_of(Loss::cauchy), 2e-3, 3e-5);
  EXPECT_GT(std::abs(offset_of(Loss::squares) - 2e-3), 1e-4);
}

TEST(KinematicCalibration, DifferencesDoNotShowTheGeometry) {
  PoseLaboratory lab(arm());
  lab.options().displacement = DisplacementKind::difference;
  std::string csv = "q1,q2,q3,q4,q5,q6,fz\n";
  for (const VectorXd& q : random_postures(6, 20, 16))
    csv += fmt::format("{},-50\n", fmt::join(q, ","));
  const Campaign campaign = lab.measure(csv);
  try {
    (void)calibrated(lab.robot(), campaign);
    FAIL() << "nothing was said";
  } catch (const common::NotIdentifiable& error) {
    EXPECT_THAT(error.what(), HasSubstr("displacement: absolute"));
  }
}

// A tool that is not the one of the file is said to be that, not fitted.
TEST(KinematicCalibration, SaysWhatIsNoErrorOfAGeometry) {
  PoseLaboratory real(arm("", "    - tool: [250, 0, 0]\n"));
  const Campaign campaign = real.measure(plan(six, random_postures(6, 60, 19)));
  PoseLaboratory lab(arm());
  try {
    (void)calibrated(lab.robot(), campaign);
    FAIL() << "nothing was said";
  } catch (const common::NotIdentifiable& error) {
    EXPECT_THAT(error.what(), HasSubstr("the shift of the tool along x"));
    EXPECT_THAT(error.what(), HasSubstr("no error of a geometry"));
  }
}

// Ridge regression: the same parameters, closer to where they start.
TEST(KinematicCalibration, APriorDrawsParametersToTheirStart) {
  PoseLaboratory lab(arm());
  lab.options().translation_noise = lab.options().rotation_noise = 2e-3;
  const Campaign campaign = lab.measure(plan(six, random_postures(6, 60, 20)));
  const auto sizes = [&](bool prior) {
    const KinematicCalibration c =
        calibrated(lab.robot(), campaign, {.folds = 0, .tolerance = {2e-3, 2e-3}, .prior = prior});
    double sum = 0;
    for (const CalibratedGeometry& g : c.geometry) sum += std::pow(g.value / g.what.tolerance, 2);
    return std::pair(c.geometry.size(), sum);
  };
  const auto [count, with] = sizes(true);
  const auto [same, without] = sizes(false);
  EXPECT_EQ(count, same);
  EXPECT_LT(with, 0.97 * without);
}

// --- another program made the readings -----------------------------------------------------------

// Denavit and Hartenberg's product, with errors in all four columns: it has nothing in common with
// the product's chains, nor its parameters with theirs.
Eigen::Isometry3d dh_pose(const std::vector<Dh>& links, const VectorXd& q) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < links.size(); ++i)
    pose = pose *
           Eigen::AngleAxisd(q[static_cast<Index>(i)] + links[i].offset, Eigen::Vector3d::UnitZ()) *
           Eigen::Translation3d(links[i].a, 0, links[i].d) *
           Eigen::AngleAxisd(links[i].alpha, Eigen::Vector3d::UnitX());
  return pose;
}

TEST(KinematicCalibration, ExplainsADenavitHartenbergRobotToTheNoise) {
  std::vector<Dh> real = table;
  Normal normal(17);
  for (Dh& link : real) {
    link.a += 5e-4 * normal();
    link.d += 5e-4 * normal();
    link.alpha += 1e-3 * normal();
    link.offset += 3e-3 * normal();
  }
  const Eigen::Isometry3d tracker = Eigen::Translation3d(2.1, -1.3, 0.4) *
                                    Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized());
  const Eigen::Vector3d target(0.034, 0.017, 0.056);  // (30, 20, 50) mm is what is known of it
  constexpr double sigma = 1e-5;
  std::string csv = "q1,q2,q3,q4,q5,q6,dx,dy,dz\n";
  for (const VectorXd& q : random_postures(6, 150, 18)) {
    Eigen::Vector3d read = tracker * dh_pose(real, q) * target;
    for (double& x : read) x += sigma * normal();
    csv += fmt::format("{},{},{},{}\n", fmt::join(q, ","), 1e3 * read[0], 1e3 * read[1],
                       1e3 * read[2]);
  }
  test::Laboratory lab(arm("", beside_axis));
  const std::filesystem::path file = test::write_campaign(
      "kinetostat: 1\ncampaign: made elsewhere\nunits: {length: mm, force: N, angle: rad}\n"
      "displacement: absolute\nsession_frame: estimate\nnoise: {translation: 0.01 mm}\n"
      "readings: readings.csv\n",
      csv);
  const KinematicCalibration c =
      calibrated(lab.robot(), read_campaign(file, lab.robot().manipulator));
  EXPECT_EQ(std::ssize(c.geometry), 21);  // beside the 6 of the frame
  const double freedom = static_cast<double>(c.values - 27);
  const double p = chance_of_larger_chi_square(
      std::pow(c.after().at_fitted.whitened, 2) * static_cast<double>(c.values), freedom);
  EXPECT_GT(p, 1e-4);
  EXPECT_LT(p, 1 - 1e-4);
  EXPECT_LT(c.after().held_out->whitened, 1.15);
}

// --- real readings -------------------------------------------------------------------------------

// What plain least squares over the table of Denavit and Hartenberg, the frame and the tool leaves
// of the same readings, by tests/calibration/kinematics/dh_least_squares.py (numpy): singular
// values below 1e-4 of the largest cut off, without which it diverges.
constexpr double dh_tool = 4.464e-4, dh_offsets = 3.660e-4, dh_all = 2.302e-4;  // [m]

const std::string ur10 = std::string(KINETOSTAT_SOURCE_DIR) + "/data/measurements/ur10_tracker/";

// The robot without weight or stiffness: kinematics alone, as that program has it.
TEST(Ur10, ComesToWhatLeastSquaresOverItsTableGives) {
  std::string text = io::read_text(ur10 + "robot.yaml");
  text.erase(text.find("uncertain:"));
  const std::size_t gravity = text.find("gravity:");
  text.erase(gravity, text.find('\n', gravity) - gravity);
  const vjm::Robot robot = vjm::parse_robot(text, ur10 + "robot.yaml");
  const KinematicCalibration c =
      calibrated(robot, read_campaign(ur10 + "campaign.yaml", robot.manipulator), {.folds = 5});
  ASSERT_EQ(c.stages.size(), 4u);
  EXPECT_NEAR(c.stages[1].at_fitted.translation, dh_tool, 0.01 * dh_tool);
  EXPECT_NEAR(c.stages[2].at_fitted.translation, dh_offsets, 0.01 * dh_offsets);
  EXPECT_NEAR(c.stages[3].at_fitted.translation, dh_all, 0.01 * dh_all);
  EXPECT_LT(c.stages[3].held_out->translation, 1.03 * dh_all);
  EXPECT_EQ(c.after().name, "links");
  // The tool has one orientation in all poses: its reach cannot be distinguished from the frame.
  EXPECT_THAT(left_out(c, LeftOut::confounded),
              Contains("the shift of the tool along z: the frame of the readings"));
  EXPECT_LT(c.observability.condition(), 100);
}

// With its weight and two stiffnesses that its file declares uncertain.
TEST(Ur10, IsPredictedBetterWithTheStiffnessOfItsJoints) {
  const vjm::Robot robot = vjm::read_robot(ur10 + "robot.yaml");
  const KinematicCalibration c =
      calibrated(robot, read_campaign(ur10 + "campaign.yaml", robot.manipulator), {.folds = 5});
  EXPECT_EQ(c.after().name, "links");
  EXPECT_LT(c.after().held_out->translation, 0.95 * dh_all);
  EXPECT_EQ(c.others.size(), 2u);
}

}  // namespace
}  // namespace kinetostat::calibration::kinematic_calibration_test
