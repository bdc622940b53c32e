#include "kinetostat/apps/studio/studio_notes.h"

#include <algorithm>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {
namespace {

using io::Json;

constexpr char mark[] = "kinetostat_studio";

Json read_notes(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return Json::object();
  Json notes = io::read_json(file);
  if (!notes.is_object() || !notes.contains(mark))
    throw common::InputError(file, "is there already, and was not written by the studio",
                             "Name another folder with --folder");
  return notes;
}

}  // namespace

StudioNotes::StudioNotes(std::filesystem::path file, const std::string& about)
    : file_(std::move(file)), notes_(read_notes(file_)) {
  if (notes_.value(mark, "") == about && notes_.contains("cards") && notes_["cards"].is_array())
    return;
  notes_ = {{mark, about}, {"cards", Json::array()}};
}

void StudioNotes::keep_card(const Json& card) {
  Json& cards = notes_["cards"];
  const auto same = std::find_if(cards.begin(), cards.end(), [&](const Json& other) {
    return other.value("name", "") == card.at("name").get<std::string>();
  });
  if (same == cards.end())
    cards.push_back(card);
  else
    *same = card;
  keep("chosen", card.at("name"));
}

void StudioNotes::remove_card(const std::string& name) {
  Json left = Json::array();
  for (const Json& card : notes_["cards"])
    if (card.value("name", "") != name) left.push_back(card);
  notes_["cards"] = std::move(left);
  write();
}

void StudioNotes::keep(const std::string& key, const Json& value) {
  notes_[key] = value;
  write();
}

// No symbolic link is followed: the folder may be open to others.
void StudioNotes::write() const {
  io::write_in_place_of(io::Replace::entry, file_, notes_.dump(1) + "\n");
}

}  // namespace kinetostat::apps
