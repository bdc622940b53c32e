// Fits and signatures as bytes, for a journal: the question as a key, the outcome as a record.
#pragma once

#include "kinetostat/calibration/search/candidate.h"
#include "kinetostat/calibration/search/fit_journal.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {

/// Key of the data that a campaign is fitted by: the readings in use and their noise.
std::string fit_scope(const Campaign& campaign, const Noise& noise);

/// Keys. `scope`: of fit_scope(). `near`: predictions of a similar model, or nullptr. `least_gain`:
/// for which the fit goes on.
std::string fit_key(const std::string& scope, const std::vector<vjm::Effect>& effects,
                    const std::vector<Parameter>& unknowns, const Predictions* near,
                    double least_gain);
/// `beside`: fitted_key() of the model that has one effect less.
std::string condensed_key(const std::string& scope, const std::vector<vjm::Effect>& effects,
                          const std::vector<Parameter>& unknowns, const std::string& beside);
/// `beside`: fitted_key() of the model that signatures are looked at in.
std::string signatures_key(const std::string& scope, const Candidate& candidate,
                           const std::string& beside);
std::string fitted_key(const std::vector<Candidate>& present, const BaseFit& fit);

/// Every bit of the fit but its parameters' descriptions, which are the question's.
std::string record_of(const BaseFit& fit);
/// Record of the failure that the readings do not determine the parameters.
std::string record_of(const common::NotIdentifiable& failure);
std::string record_of(const CandidateSignatures& signatures);
std::string record_of(const std::optional<CondensedFit>& rough);

/// Back again; nothing when a record is none of that question. Throws the common::NotIdentifiable
/// that was recorded.
std::optional<BaseFit> recorded_fit(const std::string& record,
                                    const std::vector<Parameter>& unknowns);
std::optional<std::optional<CondensedFit>> recorded_condensed_fit(
    const std::string& record, const std::vector<Parameter>& unknowns);
std::optional<CandidateSignatures> recorded_signatures(const std::string& record,
                                                       const Candidate& candidate);

}  // namespace kinetostat::calibration
