#include "kinetostat/common/byte_blocks.h"

#include <sstream>
#include <vector>

#include <gtest/gtest.h>

namespace kinetostat::common::byte_blocks_test {
namespace {

const std::vector<int> numbers{3, -1, 4};
const std::vector<double> values{1.5, -2.25};

TEST(ByteBlocks, AreReadFromAFileAsFromMemory) {
  std::istringstream file(encode_blocks(numbers, values, std::vector<int>{}));
  std::vector<int> first, last{7};
  std::vector<double> second;
  ASSERT_TRUE(read_blocks(file, first, second, last));
  EXPECT_EQ(first, numbers);
  EXPECT_EQ(second, values);
  EXPECT_TRUE(last.empty());
  EXPECT_FALSE(read_blocks(file, first));
}

TEST(ByteBlocks, MayBeBegunInOnePlaceAndEndedInAnother) {
  std::string bytes;
  append_count(bytes, numbers.size());
  bytes.append(reinterpret_cast<const char*>(numbers.data()), sizeof(int) * numbers.size());
  std::vector<int> read;
  EXPECT_TRUE(decode_blocks(bytes, read));
  EXPECT_EQ(read, numbers);
}

// A damaged count must not become an allocation of that size.
TEST(ByteBlocks, OfAFileThatEndsTooEarlyAreRefused) {
  const std::string bytes = encode_blocks(values);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    std::istringstream file(bytes.substr(0, length));
    std::vector<double> read;
    EXPECT_FALSE(read_blocks(file, read)) << length;
  }
  std::string boundless;
  append_count(boundless, ~std::uint64_t{0});
  std::istringstream file(boundless);
  std::vector<double> read;
  EXPECT_FALSE(read_blocks(file, read));
}

}  // namespace
}  // namespace kinetostat::common::byte_blocks_test
