#include "kinetostat/report/page.h"

#include <zlib.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/base64.h"
#include "kinetostat/io/text_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::report::page_test {
namespace {

using io::Json;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>&\"";

std::vector<PageResult> two_results() {
  return {{.result = {{"command", "compare"}, {"campaign", {{"name", evil}}}},
           .picture = {{"x", {1.5, nullptr, -2}}},
           .text = "a < b\n" + evil},
          {.result = {{"command", "identify"}, {"link", "foot"}}, .picture = {}, .text = {}}};
}

class Page : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_pages()) GTEST_SKIP() << "built without pages";
  }
  std::filesystem::path written(const std::string& text) const {
    io::write_atomically(folder_.path() / "file", text);
    return folder_.path() / "file";
  }
  test::TemporaryFolder folder_;
};

TEST_F(Page, GivesItsResultsBack) {
  const auto results = read_page_results(written(page("both", two_results())));
  ASSERT_EQ(results.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(results[i].result, two_results()[i].result);
    EXPECT_EQ(results[i].picture, two_results()[i].picture);
    EXPECT_EQ(results[i].text, two_results()[i].text);
  }
}

TEST_F(Page, TakesNoNameForMarkup) {
  const std::string html = page(evil, two_results());
  EXPECT_THAT(html, Not(HasSubstr("alert(1)</script>")));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(html, HasSubstr("<title>&lt;/script&gt;&lt;script&gt;alert(1)"));
  // A placeholder of the shell in a name is text, too.
  EXPECT_THAT(page("@RESULTS@ @TEXT@", two_results()),
              HasSubstr("<title>@RESULTS@ @TEXT@</title>"));
}

TEST_F(Page, MayAskOnlyTheStudioForAnything) {
  EXPECT_THAT(page("t", {}), HasSubstr("connect-src 'none'"));
  EXPECT_THAT(page("t", {}, PageHost::studio), HasSubstr("connect-src 'self'"));
  EXPECT_THAT(page("t", {}), HasSubstr("default-src 'none'"));
}

TEST_F(Page, HasTheSameBytesForTheSameResults) {
  EXPECT_EQ(page("t", two_results()), page("t", two_results()));
}

TEST_F(Page, LeavesOutWhatItsPictureHolds) {
  PageResult entry{.result = {{"as_designed", Json::object()}, {"readings", {1, 2}}},
                   .picture = {{"readings", Json::object()}},
                   .text = {}};
  EXPECT_FALSE(read_page_results(written(page("t", {entry})))[0].result.contains("readings"));
  entry.picture = nullptr;
  EXPECT_TRUE(read_page_results(written(page("t", {entry})))[0].result.contains("readings"));
}

TEST_F(Page, RefusesWhatIsNoResult) {
  const std::string whole = page("t", two_results());
  const std::size_t data = whole.find("id=\"results\">") + 13;
  std::string spoiled = whole;
  spoiled[data + 20] = spoiled[data + 20] == 'A' ? 'B' : 'A';
  std::string cut = whole;
  cut.erase(data + 8, 4);
  for (const std::string& text : {std::string("no JSON"), std::string("[1, 2]"), std::string(),
                                  spoiled, cut, whole.substr(0, data + 16)})
    EXPECT_THROW(read_page_results(written(text)), common::InputError) << text.substr(0, 40);
}

// A page of a hundred kilobytes that stands for gigabytes.
std::string bomb(const std::string& results) {
  uLongf size = compressBound(results.size());
  std::string bytes(size, '\0');
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                     reinterpret_cast<const Bytef*>(results.data()), results.size()),
            Z_OK);
  bytes.resize(size);
  return "<script type=\"application/octet-stream\" id=\"results\">" + io::base64(bytes) +
         "</script>";
}

TEST_F(Page, TakesLittleMemoryWhateverItHolds) {
  const auto expect_too_large = [this](const std::string& results) {
    const std::string html = bomb(results);
    EXPECT_LT(html.size(), 300'000u);
    try {
      (void)read_page_results(written(html));
      FAIL() << "accepted";
    } catch (const common::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("more than is read back"));
    }
  };
  expect_too_large("[" + std::string(std::size_t{140} << 20, ' ') + "]");
  std::string lists;
  while (lists.size() < (std::size_t{100} << 20)) lists += "[],[],[],[],[],[],[],[],[],[],";
  expect_too_large("[" + lists + "[]]");
}

TEST(TitleOfResult, SaysCommandAndSubject) {
  EXPECT_EQ(title_of({{"command", "diagnose"}, {"campaign", "bench"}}), "diagnose: bench");
  EXPECT_EQ(title_of({{"command", "compare"}, {"campaign", {{"name", "bench"}}}}),
            "compare: bench");
  EXPECT_EQ(title_of({{"command", "map"}, {"inputs", {{"name", "arm"}}}}), "map: arm");
  EXPECT_EQ(title_of({{"link", "foot"}}), "foot");
  EXPECT_EQ(title_of(Json::object()), "kinetostat");
}

}  // namespace
}  // namespace kinetostat::report::page_test
