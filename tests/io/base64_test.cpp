#include "kinetostat/io/base64.h"

#include <gtest/gtest.h>

namespace kinetostat::io::base64_test {
namespace {

// RFC 4648, section 10.
TEST(Base64, IsThatOfTheStandard) {
  const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : vectors) {
    EXPECT_EQ(base64(bytes), text);
    EXPECT_EQ(from_base64(text), bytes);
  }
}

TEST(Base64, GivesEveryByteBack) {
  std::string bytes;
  for (int k = 0; k < 256; ++k) bytes += static_cast<char>(k);
  for (std::size_t cut = 0; cut < 4; ++cut) {
    const std::string some = bytes.substr(0, bytes.size() - cut);
    EXPECT_EQ(from_base64(base64(some)), some);
  }
  // Bytes above 127 use the last two letters.
  EXPECT_EQ(base64("\xfb\xff\xbf"), "+/+/");
}

TEST(Base64, RefusesOtherLetters) {
  for (const char* text : {"Zm9v\n", "Zm 9v", "Zm9-", "Z=9v", "Zm9\xc3"})
    EXPECT_EQ(from_base64(text), std::nullopt) << text;
  EXPECT_EQ(from_base64("Zg"), "f");
}

}  // namespace
}  // namespace kinetostat::io::base64_test
