// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/vulkan_sampling.h"

#include <bit>
#include <cstring>
#include <utility>

namespace gxy::vulkan {

static_assert(MOST_SAMPLED_FIELDS == kMostSampledFields);

VulkanSampling::VulkanSampling(const Device& device, const Pipelines& pipelines, SharedData& shared,
                               std::shared_ptr<const CompiledSampling> sampling,
                               std::span<const int> partitions, int rank)
    : sampling_(std::move(sampling)) {
  for (const int p : partitions)
    parts_.emplace(p, uploadFields(device, pipelines, shared, *sampling_, p, rank));
}

std::vector<int32_t> VulkanSampling::view() const {
  const CompiledSampling& s = *sampling_;
  std::vector<int32_t> words;
  const auto put = [&words](const auto& values) {
    const auto at = uint32_t(words.size());
    for (const auto value : values) words.push_back(std::bit_cast<int32_t>(value));
    return at;
  };
  shader::SamplingView v{};
  v.fields = int(s.views.size());
  v.field = uint32_t(s.scene->operators.size());
  v.isovalueOf = put(s.isovalueOf);
  v.gradient = s.gradient;
  v.conditions = int(s.conditionField.size());
  v.conditionOperator = put(s.conditionOperator);
  v.conditionField = put(s.conditionField);
  v.conditionRange = put(s.conditionRange);
  v.hits = put(s.hits);
  static_assert(sizeof v % sizeof(int32_t) == 0);
  words.insert(words.begin(), sizeof v / sizeof(int32_t), 0);
  std::memcpy(words.data(), &v, sizeof v);
  return words;
}

size_t VulkanSampling::words() const {
  return SAMPLE_WORDS + sampling_->views.size() + (sampling_->gradient ? 3 : 0);
}

void VulkanSampling::take(std::span<const int32_t> written, int partition, SampleList& samples) const {
  const auto real = [](int32_t word) { return std::bit_cast<float>(word); };
  const size_t fields = sampling_->views.size();
  std::vector<float> values(fields + 3);
  for (; !written.empty(); written = written.subspan(words())) {
    const int32_t* w = written.data();
    for (size_t k = 0; k < words() - SAMPLE_WORDS; k++) values[k] = real(w[SAMPLE_WORDS + k]);
    addSample(*sampling_,
              {uint32_t(w[0]) | uint64_t(uint32_t(w[1])) << 32,
               uint32_t(w[2]),
               uint32_t(w[3]),
               uint32_t(w[4]),
               real(w[5]),
               {{real(w[6]), real(w[7]), real(w[8])},
                {real(w[9]), real(w[10]), real(w[11])},
                uint32_t(w[12]),
                uint32_t(w[13]),
                partition},
               values.data(),
               1,
               values.data() + fields},
              samples);
  }
}

}  // namespace gxy::vulkan
