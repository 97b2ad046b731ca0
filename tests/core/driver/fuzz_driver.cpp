// SPDX-License-Identifier: Apache-2.0
// Coverage-guided fuzzing of the driver (libFuzzer). The input is a list of datagrams, each after two bytes of length;
// its first byte says whether the driver has a key and whether the fuzzer knows it.
#include <algorithm>
#include <cstdlib>

#include "driver/driver.hpp"
#include "skin/skin_reader.hpp"

using namespace robotskin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const bool keyed = (data[0] & 1U) != 0, known = (data[0] & 2U) != 0;
  driver::Options options;
  for (std::uint32_t id = 1; id <= 16; ++id) options.keys.push_back(id);
  if (keyed) options.key = driver::Key{};
  options.spare_cells = 4;
  options.spare_groups = 1;
  driver::Driver driver(options);
  skin::SkinModel model;
  model.key = options.keys;
  skin::SkinReader reader(driver.samples(), model);
  skin::SkinState state;
  state.resize(model.size());
  const driver::KeyedHash hash{driver::Key{}};
  std::int64_t now_ns = 1'000'000'000;
  for (std::size_t at = 1; at + 2 <= size;) {
    const std::size_t length = std::min<std::size_t>((std::size_t{data[at]} << 8 | data[at + 1]) % 1500, size - at - 2);
    std::vector<std::uint8_t> datagram(data + at + 2, data + at + 2 + length);
    at += 2 + length;
    if (known && length > RS_DATAGRAM_HEADER_BYTES + RS_DATAGRAM_TAG_BYTES) {
      // The fuzzer cannot find tags or sessions by itself: fill them in.
      rs_store32(datagram.data() + 32, driver.session());
      const std::size_t covered = length - RS_DATAGRAM_TAG_BYTES;
      const driver::Tag tag = hash.tag({datagram.data(), covered});
      std::copy(tag.begin(), tag.end(), datagram.begin() + static_cast<std::ptrdiff_t>(covered));
    }
    now_ns += 100'000;
    const driver::Verdict verdict = driver.handle(datagram, now_ns);
    if (keyed && !known && verdict == driver::Verdict::accepted) std::abort();
    driver.publish(now_ns);
    driver.downlink(now_ns, [](const driver::Recipient&, std::span<const std::uint8_t>) {});
    reader.read(now_ns, state);
  }
  return 0;
}
