#include "kinetostat/vjm/workspace/map_checkpoint.h"

#include <charconv>
#include <string_view>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::vjm {
namespace {

constexpr std::string_view older = "kinetostat map checkpoint 1";
constexpr std::string_view heading = "kinetostat map checkpoint 2";

// Of all that follows it, and of the request before it.
std::string seal_of(std::string_view request, std::string_view points) {
  return io::sha256(fmt::format("{}\n{}", request, points));
}

// One line a pose: its state as a number, then its values with the digits that read back the same.
class CheckpointReader {
 public:
  CheckpointReader(const std::filesystem::path& file, const std::string& text)
      : file_(file), rest_(text) {}

  std::string_view line() {
    ++line_;
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) fail("ends in the middle of a line");
    const std::string_view taken = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return taken;
  }
  bool at_end() const { return rest_.empty(); }

  // One flipped digit would be another map, and nobody would see it.
  void require_seal(std::string_view request) {
    const std::string_view seal = line();
    if (seal != seal_of(request, rest_)) fail("was damaged: its content does not fit its checksum");
  }

  MapPoint point(std::size_t indices) {
    std::string_view text = line();
    MapPoint point;
    const double state = number(text);
    if (!(state >= 0 && state <= static_cast<int>(MapState::unreachable)) ||
        state != static_cast<int>(state))
      fail("has no such state");
    point.state = static_cast<MapState>(static_cast<int>(state));
    for (std::size_t i = 0; i < indices; ++i) point.values.push_back(number(text));
    if (!text.empty()) fail("has too many values");
    return point;
  }

  [[noreturn]] void fail(const char* what) const {
    throw common::InputError(
        {.file = file_,
         .line = line_,
         .what = fmt::format("the checkpoint of the map {}", what),
         .cure = "Delete the file to start the map afresh, or name another with --checkpoint"});
  }

 private:
  double number(std::string_view& text) const {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) fail("has a value that is not a number");
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.starts_with(' ')) text.remove_prefix(1);
    return value;
  }

  const std::filesystem::path& file_;
  std::string_view rest_;
  int line_ = 0;
};

std::string request_line(const MapCheckpoint& checkpoint, std::size_t poses) {
  return fmt::format("{} {} poses", checkpoint.request, poses);
}

}  // namespace

std::vector<MapPoint> read_map_checkpoint(const MapCheckpoint& checkpoint, std::size_t poses,
                                          std::size_t indices) {
  std::vector<MapPoint> points;
  if (!std::filesystem::exists(checkpoint.file)) return points;
  const std::string text = io::read_text(checkpoint.file);
  CheckpointReader reader(checkpoint.file, text);
  const std::string_view first = reader.line();
  if (first == older) reader.fail("was written by an older version of this program");
  if (first != heading) reader.fail("does not start as one");
  const std::string request = request_line(checkpoint, poses);
  if (reader.line() != request)
    reader.fail("belongs to another robot, other options or another build of the program");
  reader.require_seal(request);
  while (!reader.at_end()) {
    if (points.size() == poses) reader.fail("has more poses than the map");
    points.push_back(reader.point(indices));
  }
  return points;
}

void write_map_checkpoint(const MapCheckpoint& checkpoint, const std::vector<MapPoint>& points,
                          std::size_t poses) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  for (const MapPoint& point : points) {
    fmt::format_to(out, "{}", static_cast<int>(point.state));
    for (const double value : point.values) fmt::format_to(out, " {}", value);
    fmt::format_to(out, "\n");
  }
  const std::string lines = fmt::to_string(text), request = request_line(checkpoint, poses);
  io::write_atomically(checkpoint.file, fmt::format("{}\n{}\n{}\n{}", heading, request,
                                                    seal_of(request, lines), lines));
}

}  // namespace kinetostat::vjm
