// Where fits and signatures are kept, so that a search that was interrupted goes on where it was.
#pragma once

#include <optional>
#include <string>

#include "kinetostat/common/progress.h"

namespace kinetostat::calibration {

/// Given to a search by whoever has a place to keep things; a search without one computes all anew.
/// The whole outcome is kept, bit for bit: it holds the equilibria from which later fits start, so
/// a search that goes on gives the bytes of one that was never interrupted, and no figure depends
/// on whether there is a journal.
class FitJournal {
 public:
  FitJournal() = default;
  FitJournal(const FitJournal&) = delete;
  FitJournal& operator=(const FitJournal&) = delete;
  virtual ~FitJournal() = default;

  /// The content that was kept under a key, or nothing. A key is a SHA-256 of all that is asked of
  /// one robot and one campaign, as they were read, by one build of the program: a journal must
  /// find nothing that was kept for another. Never found: content that is not as it was kept.
  virtual std::optional<std::string> find(const std::string& key) = 0;
  /// May fail silently: what is not kept is computed again.
  virtual void keep(const std::string& key, const std::string& content) = 0;

  /// Where several workers use the same journal at once: whether nobody else works on this item,
  /// which is then the caller's until it gives it up. The item is named by all that is asked, as a
  /// key is. Any thread may call. It saves work, and decides no figure.
  virtual bool claim(const std::string& /*item*/) { return true; }
  virtual void give_up(const std::string& /*item*/) {}
};

/// An item of work, given up at the end of a block. Without a journal (nullptr), or where nobody
/// else uses it, the item is free at once.
class Claim {
 public:
  Claim(FitJournal* journal, std::string item);
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;
  ~Claim();

  /// False while another one works on it.
  bool try_once();
  /// Waits until no other one works on it. Throws common::Cancelled.
  void wait(common::Progress& progress);

 private:
  FitJournal* journal_;
  std::string item_;
  bool is_held_ = false;
};

/// Until it is worth asking again whether an item is free.
void wait_a_moment();

}  // namespace kinetostat::calibration
