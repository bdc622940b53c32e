// Six stations from readings to a model that explains them: what each says in one sentence.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign_check.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

enum class Light { good, open, bad };  // green, amber, red

struct Station {
  std::string name, sentence;
  Light light = Light::open;
};

Station readings_station(const calibration::Campaign& campaign,
                         const std::vector<calibration::Observability>& checks);
/// The model as its file has it.
Station model_station(const calibration::Comparison& comparison);
Station fitted_station(const vjm::Robot& robot, const calibration::Comparison& comparison);
Station missing_station(const vjm::Robot& robot, const calibration::Diagnosis& diagnosis);
/// The file that was written, compared again. `set_aside`: how many readings alone make it fail.
Station adopted_station(const std::string& file, const calibration::Comparison& again,
                        std::size_t set_aside = 0);
/// Nothing was adopted.
Station not_adopted_station(const std::string& why, calibration::Verdict verdict);
Station next_station(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                     const calibration::Plan& plan);
Station nothing_next_station(const std::string& why);

io::Json to_json(const Station& station);
/// Throws io::Json::exception where it is none.
Station station_of(const io::Json& json);
/// One line each, numbered.
std::string text(const std::vector<Station>& stations);

}  // namespace kinetostat::report
