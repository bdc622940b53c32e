// twin_cases: makes cases with hidden effects.
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "campaign_text.h"
#include "case.h"
#include "confuser.h"
#include "sensor_case.h"

namespace {

constexpr const char* usage =
    "usage: twin_cases --list                         names, classes and rounds\n"
    "       twin_cases --trial                        the same of the trial robots; round 0: held "
    "back\n"
    "       twin_cases --case NAME FOLDER TRUTH.json  writes one case\n"
    "       twin_cases --confuser NAME SIZE ENOUGH CONFUSER.json\n"
    "                      what looks like that which is hidden in it, up to a cosine\n"
    "       twin_cases --follow-up NAME FROM TABLE.csv NUMBER KIND FOLDER SIZE...\n"
    "                      measures a plan after the campaign in FROM; KIND: differences, poses, "
    "weights, poses,weights\n"
    "       twin_cases --agreement ROBOT PLAN FOLDER  no noise, nothing hidden, the true "
    "stiffnesses\n"
    "       twin_cases --foundation SENSORS NOISE FOLDER [hidden|ground|bodies|light]...  an arm "
    "on a "
    "foundation that yields, under weights or a cylinder\n"
    "       twin_cases --tracker NOISE FOLDER  an arm under a payload, an unknown target and "
    "tracker\n"
    "       twin_cases --frame NOISE PLAY FOLDER  four dial gauges under a frame in torsion\n";

twin::Case case_named(const std::string& name) {
  for (const std::vector<twin::Case>& cases : {twin::suite(), twin::trial_suite(), twin::stories()})
    for (const twin::Case& c : cases)
      if (c.name == name) return c;
  throw std::runtime_error("no case " + name);
}

void follow_up(const std::vector<std::string>& words) {
  std::vector<double> sizes;
  for (std::size_t i = 7; i < words.size(); ++i) sizes.push_back(std::stod(words[i]));
  twin::write_follow_up(case_named(words[1]), sizes,
                        {.from = words[2],
                         .table = words[3],
                         .number = std::stoi(words[4]),
                         .absolute = words[5].find("poses") != std::string::npos,
                         .known_loads = words[5].find("weights") != std::string::npos},
                        words[6]);
}

int run(const std::vector<std::string>& words) {
  if (words == std::vector<std::string>{"--list"}) {
    for (const twin::Case& c : twin::suite()) fmt::print("{} {} {}\n", c.name, c.kind, c.round);
    return 0;
  }
  if (words == std::vector<std::string>{"--trial"}) {
    for (const twin::Case& c : twin::trial_suite())
      fmt::print("{} {} {}\n", c.name, c.kind, c.held_back ? 0 : c.round);
    return 0;
  }
  if (words.size() == 4 && words[0] == "--agreement") {
    twin::write_agreement(words[1], words[2], 16, words[3]);
    return 0;
  }
  if (words.size() >= 4 && words[0] == "--foundation") {
    twin::FoundationCase spec;
    spec.sensors = words[1];
    const double noise = std::stod(words[2]);
    spec.tilt_noise *= noise;
    spec.length_noise *= noise;
    for (std::size_t i = 4; i < words.size(); ++i) {
      if (words[i] == "hidden")
        spec.foundation_in_file = false;
      else if (words[i] == "light")
        spec.light = true;
      else
        spec.cylinder = words[i];
    }
    twin::write_foundation(spec, words[3]);
    return 0;
  }
  if (words.size() == 3 && words[0] == "--tracker") {
    twin::TrackerCase spec;
    spec.noise *= std::stod(words[1]);
    twin::write_tracker(spec, words[2]);
    return 0;
  }
  if (words.size() == 4 && words[0] == "--frame") {
    twin::FrameCase spec;
    spec.noise *= std::stod(words[1]);
    spec.play = std::stod(words[2]);
    twin::write_frame(spec, words[3]);
    return 0;
  }
  if (words.size() == 4 && words[0] == "--case") {
    twin::write_case(case_named(words[1]), words[2], words[3]);
    return 0;
  }
  if (words.size() >= 7 && words[0] == "--follow-up") {
    follow_up(words);
    return 0;
  }
  if (words.size() == 5 && words[0] == "--confuser") {
    const twin::Confuser found =
        twin::confuser_in(case_named(words[1]), std::stod(words[2]), std::stod(words[3]));
    twin::write_text(words[4], fmt::format("{{\"confuser\": \"{}\", \"cosine\": {:.3f}}}\n",
                                           found.name, found.cosine));
    return 0;
  }
  fmt::print(stderr, "{}", usage);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
