// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/scene_upload.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "backends/vulkan/hierarchy.h"
#include "backends/vulkan/shader_views.h"
#include "core/data/bricks.h"
#include "core/rays/fill_views.h"

namespace gxy::vulkan {

namespace {

constexpr size_t kSectionAlignment = 256;  // no device asks for more
constexpr VkFormat kWords = VK_FORMAT_R32_UINT, kQuads = VK_FORMAT_R32G32B32A32_UINT;

// Arrays one behind the other, found by the index of their first word; 0 stands for none.
class Words {
 public:
  template <class T>
  uint32_t add(std::span<const T> values) {
    static_assert(sizeof(T) % 4 == 0);
    if (values.empty()) return 0;
    const size_t at = words_.size();  // a multiple of 4, so that four words can be read at once
    if (at + values.size_bytes() / 4 > kMost)
      throw Error("a partition has more than 8 GiB of geometry or tables; cut the data into more partitions");
    words_.resize((at + values.size_bytes() / 4 + 3) / 4 * 4);
    std::memcpy(words_.data() + at, values.data(), values.size_bytes());
    return uint32_t(at);
  }
  template <class T>
  uint32_t add(const std::vector<T>& values) {
    return add(std::span<const T>(values));
  }
  std::span<const std::byte> bytes() const { return std::as_bytes(std::span(words_)); }

 private:
  // SPIR-V takes the index of an array's element for a signed number.
  static constexpr size_t kMost = std::numeric_limits<int32_t>::max();
  std::vector<uint32_t> words_ = std::vector<uint32_t>(4, 0);
};

const OperatorInPartition* shownIn(const CompiledOperator& op, int partition) {
  const auto found = op.parts.find(partition);
  return found == op.parts.end() ? nullptr : &found->second;
}

// The blocks of a partition, each once; scenes with the same blocks share them.
std::vector<const VolumeBlock*> blocksOf(std::span<const CompiledOperator> operators, int partition) {
  std::vector<const VolumeBlock*> blocks;
  for (const CompiledOperator& op : operators)
    if (const OperatorInPartition* part = shownIn(op, partition); part && part->block)
      if (std::find(blocks.begin(), blocks.end(), part->block) == blocks.end()) blocks.push_back(part->block);
  return blocks;
}

// Whether the act of a sampling is to find the blocks of the scene's operators beside those of its fields: it reads them for
// gradients. If they hold all fields, the samples are those that the scene has on the device.
bool needsBlocksOfScene(const CompiledSampling& sampling, int partition) {
  const std::vector<const VolumeBlock*> there = blocksOf(sampling.scene->operators, partition),
                                        read = blocksOf(sampling.views, partition);
  return sampling.gradient || std::all_of(read.begin(), read.end(), [&](const VolumeBlock* block) {
           return std::find(there.begin(), there.end(), block) != there.end();
         });
}

// The geometry of each operator in a partition, or null, and then the cells that its surfaces pass, or null; scenes with the same ones
// share them.
std::vector<const GeometryInPartition*> geometryOf(const CompiledScene& scene, int partition) {
  std::vector<const GeometryInPartition*> geometry, surfaces;
  for (const CompiledOperator& op : scene.operators) {
    const OperatorInPartition* part = shownIn(op, partition);
    geometry.push_back(part ? part->geometry.get() : nullptr);
    surfaces.push_back(part ? part->surfaces.get() : nullptr);
  }
  geometry.insert(geometry.end(), surfaces.begin(), surfaces.end());
  return geometry;
}

// The `put` of fill_views.h: samples go one behind the other, all else goes to `words`, which are tables or
// geometry.
class Places {
 public:
  explicit Places(Words& words) : words_(words) {}
  template <class T>
  uint32_t operator()(const std::vector<T>& v) {
    return words_.add(v);
  }
  uint32_t operator()(const std::vector<uint8_t>& v) {
    return words_.add(std::vector<uint32_t>(v.begin(), v.end()));
  }
  // The place that a block will have, in units of 16 bytes; the same for all operators that show it. Place 0
  // stands for none.
  uint32_t samples(const VolumeBlock& block) {
    for (const auto& [known, place] : blocks_)
      if (known == &block) return place;
    if (block.samples.size() >= size_t(1) << 35 || sampleBytes_ / 16 > std::numeric_limits<uint32_t>::max())
      throw Error("a volume has more than 32 GiB in one partition; cut it into more partitions");
    const auto place = uint32_t(sampleBytes_ / 16);
    blocks_.emplace_back(&block, place);
    sampleBytes_ += (block.samples.size() + 15) / 16 * 16;
    return place;
  }
  const std::vector<std::pair<const VolumeBlock*, uint32_t>>& blocks() const { return blocks_; }
  /// The key of what scenes share.
  std::vector<const VolumeBlock*> listOfBlocks() const {
    std::vector<const VolumeBlock*> list;
    for (const auto& [block, place] : blocks_) list.push_back(block);
    return list;
  }
  size_t sampleBytes() const { return sampleBytes_; }

 private:
  Words& words_;
  std::vector<std::pair<const VolumeBlock*, uint32_t>> blocks_;
  size_t sampleBytes_ = 16;
};

// Builds what the stages read, then copies it to the device.
class Uploading {
 public:
  Uploading(const Device& device, const CompiledScene& scene, int partition, int rank, const Advance& advance)
      : device_(device), scene_(scene), partition_(partition), advance_(advance) {
    begin();
    primitives_ = geometryOf(scene, partition);
    out_.special.routes = 0;
    if (!scene.opaqueSurfaces) out_.special.routes |= ROUTE_ON;
    if (partition < 0 ||
        scene.visible.size() - size_t(std::count(scene.visible.begin(), scene.visible.end(), 0)) > 1)
      out_.special.routes |= ROUTE_LEAVES;
    for (size_t i = 0; i < scene.operators.size(); i++) {
      const CompiledOperator& op = scene.operators[i];
      const OperatorInPartition* part = shownIn(op, partition);
      fillVolumeView(fields_.emplace_back(), op, part, inTables_);
      shader::OperatorView& view = operators_.emplace_back();
      fillOperatorView(view, op, inTables_);
      if (primitives_[scene.operators.size() + i])
        out_.geometryKinds |= view.kind == KIND_MESH ? SURFACE_CELLS : SURFACE_HEXES;
      if (primitives_[i]) {
        constexpr int kBits[] = {0, SURFACE_PARTICLES, SURFACE_PATHLINES, SURFACE_TRIANGLES};
        if (!op.data.mesh) out_.geometryKinds |= kBits[view.kind];
      }
      out_.hasBlock.push_back(part && part->block);
      out_.hasCells.push_back(primitives_[i] && op.data.mesh);
      out_.hasIsosurface.push_back(part && !part->isoMask.empty());
      if (part && part->block) checkNumbering(part->block->extent.points, op.data.volume->components);
    }
    out_.volumeList = tables_.add(scene.rendered);
    end(rank);
  }

  // For the act of a sampling, which reads no more of the operators than isovalues and samples.
  Uploading(const Device& device, const CompiledSampling& sampling, int partition, int rank,
            const Advance& advance)
      : device_(device), scene_(*sampling.scene), partition_(partition), advance_(advance) {
    begin();
    isScene_ = false;
    const bool ofScene = needsBlocksOfScene(sampling, partition);
    const auto add = [&](const CompiledOperator& op, bool withBlock) {
      const OperatorInPartition* part = shownIn(op, partition);
      OperatorInPartition only;
      if (part && withBlock) only.block = part->block;
      if (only.block) checkNumbering(only.block->extent.points, op.data.volume->components);
      fillVolumeView(fields_.emplace_back(), op, &only, inTables_);
      fillOperatorView(operators_.emplace_back(), op, inTables_);
    };
    for (const CompiledOperator& op : scene_.operators) add(op, ofScene);
    for (const CompiledOperator& field : sampling.views) add(field, true);
    end(rank);
  }

  PartitionOnDevice finish(const Pipelines& pipelines, SharedData& shared) {
    if (std::any_of(primitives_.begin(), primitives_.end(), [](const auto* part) { return part; })) {
      out_.geometry = shared.geometry.get(
          primitives_, [&] { return makeGeometry(); }, [&] { advance_(0); });
      view_.hierarchy = out_.geometry->hierarchy;
      const size_t operators = scene_.operators.size();
      for (size_t i = 0; i < operators; i++) {
        const shader::OperatorView& at = out_.geometry->places[i];
        shader::OperatorView& view = operators_[i];
        view.primitives = at.primitives;
        view.points = at.points;
        view.normals = at.normals;
        view.values = at.values;
        view.colors = at.colors;
        view.indices = at.indices;
        view.neighbours = at.neighbours;
        view.orders = at.orders;
        view.shell = at.shell;
        view.unseen = at.unseen;
        view.surfaceCells = at.surfaceCells;
        view.levelCorners = at.levelCorners;
        view.levelValues = at.levelValues;
        view.levelGradients = at.levelGradients;
        view.levelPoints = at.levelPoints;
        view.levelOrders = at.levelOrders;
        view.surfaces = at.surfaces;
        view.shellHierarchy = at.shellHierarchy;
      }
    }
    const auto sceneBytes = std::as_bytes(std::span(&view_, 1));
    const auto operatorBytes = std::as_bytes(std::span(operators_)),
               fieldBytes = std::as_bytes(std::span(fields_));
    const std::span<const std::byte> sections[] = {sceneBytes, operatorBytes, fieldBytes, tables_.bytes()};
    size_t at[5] = {0};
    for (int i = 0; i < 4; i++) {
      const size_t end = at[i] + std::max<size_t>(sections[i].size(), 4);
      at[i + 1] = (end + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
    }
    // The addresses follow the sections.
    out_.scene = Buffer(device_, at[4] + sizeof(VkDeviceAddress[3]), Place::Device, "the scene");
    for (int i = 0; i < 4; i++)
      if (!sections[i].empty()) upload(device_, out_.scene, at[i], sections[i]);
    if (!inTables_.blocks().empty()) {
      out_.samples = shared.samples.get(
          inTables_.listOfBlocks(), [&] { return makeSamples(); }, [&] { advance_(0.5); });
    }
    const VkDeviceAddress addresses[3] = {out_.scene.address() + at[3],
                                          out_.samples ? out_.samples->buffer.address() : 0,
                                          out_.geometry ? out_.geometry->buffer.address() : 0};
    upload(device_, out_.scene, at[4], std::as_bytes(std::span(addresses)));

    const auto section = [&](int i) {
      return VkDescriptorBufferInfo{out_.scene.get(), at[i], std::max<size_t>(sections[i].size(), 4)};
    };
    const VkDescriptorBufferInfo nothing{out_.scene.get(), 0, 16};
    Binding bindings[SCENE_BINDINGS] = {{section(0)},
                                        {section(1)},
                                        {section(2)},
                                        {section(3), kWords},
                                        {nothing, kWords},
                                        {nothing, kWords},
                                        {{out_.scene.get(), at[4], sizeof addresses}},
                                        {section(3), kQuads},
                                        {nothing, kQuads},
                                        {section(3)},
                                        {nothing, kQuads}};
    const auto whole = [](const Buffer& b) { return VkDescriptorBufferInfo{b.get(), 0, b.bytes()}; };
    if (out_.samples) bindings[SAMPLES_BINDING].buffer = whole(out_.samples->buffer);
    if (out_.geometry) bindings[GEOMETRY_BINDING].buffer = whole(out_.geometry->buffer);
    bindings[GEOMETRY_QUADS_BINDING].buffer = bindings[GEOMETRY_BINDING].buffer;
    bindings[SAMPLE_QUADS_BINDING].buffer = bindings[SAMPLES_BINDING].buffer;
    struct Large {
      int words, quads, inQuads, addressed;
    };
    constexpr Large kLarge[] = {
        {TABLES_BINDING, TABLE_QUADS_BINDING, QUADS_TABLES, ADDRESSED_TABLES},
        {SAMPLES_BINDING, SAMPLE_QUADS_BINDING, QUADS_SAMPLES, ADDRESSED_SAMPLES},
        {GEOMETRY_BINDING, GEOMETRY_QUADS_BINDING, QUADS_GEOMETRY, ADDRESSED_GEOMETRY}};
    for (const Large& large : kLarge) {
      const VkDeviceSize bytes = bindings[large.words].buffer.range;
      if (bytes <= device_.largestBinding()) continue;
      bindings[large.words].buffer = nothing;
      const bool inQuads = bytes <= device_.largestQuads();
      if (!inQuads) bindings[large.quads].buffer = nothing;
      out_.special.addressed |= inQuads ? large.inQuads : large.addressed;
    }
    if (bindings[TABLES_AHEAD_BINDING].buffer.range > device_.largestStorage()) {
      bindings[TABLES_AHEAD_BINDING].buffer = nothing;
      out_.special.mapAhead = 0;
    }
    out_.set = DescriptorSet(device_, pipelines.setLayout(SCENE_SET), bindings);
    return std::move(out_);
  }

 private:
  void begin() {
    out_.partition = partition_;
    out_.special.limited = device_.endsLoops();
  }

  void end(int rank) {
    std::vector<uint32_t> mine(scene_.visible.size());
    for (size_t p = 0; p < mine.size(); p++)
      mine[p] = scene_.visible[p] && scene_.partitioning->owner(int(p)) == rank;
    out_.mine = tables_.add(mine);
    fillSceneView(view_, scene_, partition_, inTables_);
    view_.operators = int(scene_.operators.size());
    specialize();
  }

  SamplesOnDevice makeSamples() const {
    SamplesOnDevice made{Buffer(device_, inTables_.sampleBytes(), Place::Device, "volumes"), {}};
    const Advance uploading = partOf(advance_, 1, 2);
    const auto& blocks = inTables_.blocks();
    for (size_t i = 0; i < blocks.size(); i++)
      upload(device_, made.buffer, size_t(blocks[i].second) * 16, blocks[i].first->samples,
             partOf(uploading, i, blocks.size()));
    if (isScene_) made.charge = Charge(device_, made.buffer.bytes());
    return made;
  }

  // Returns the place of a hierarchy, with that of its list of primitives before its nodes.
  static uint32_t add(const Hierarchy& hierarchy, Words& words) {
    const uint32_t list = words.add(hierarchy.primitives);
    const size_t count = hierarchy.nodes.size() / NODE_WORDS;
    const float nodes = std::nextafter(float(count), 1e30f);
    const uint32_t place = words.add(std::vector<uint32_t>{list, std::bit_cast<uint32_t>(nodes)});
    words.add(hierarchy.nodes);
    return place;
  }

  GeometryOnDevice makeGeometry() const {
    GeometryOnDevice made;
    Words words;
    Places places(words);
    const size_t operators = scene_.operators.size();
    for (size_t i = 0; i < operators; i++) {
      shader::OperatorView& at = made.places.emplace_back();
      if (primitives_[i]) fillPrimitives(at, *primitives_[i], places);
      if (primitives_[operators + i]) fillSurfaces(at, *primitives_[operators + i], places);
    }
    made.hierarchy = add(hierarchyOf(scene_, partition_, partOf(advance_, 0, 4)), words);
    for (size_t i = 0; i < operators; i++)
      if (out_.hasCells[i])
        made.places[i].shellHierarchy =
            add(shellHierarchyOf(scene_, int(i), partition_, partOf(advance_, 0, 4)), words);
    made.buffer = Buffer(device_, words.bytes().size(), Place::Device, "geometry");
    upload(device_, made.buffer, 0, words.bytes(), partOf(advance_, 1, 4));
    made.charge = Charge(device_, made.buffer.bytes());
    return made;
  }

  void specialize() {
    int kind = -2;
    bool scalars = true;
    for (size_t i = 0; i < fields_.size(); i++) {
      if (operators_[i].kind != KIND_VOLUME) continue;
      kind = kind == -2 || kind == fields_[i].kind ? fields_[i].kind : -1;
      scalars = scalars && fields_[i].stride == 1;
    }
    out_.special.sampleKind = std::max(kind, -1);
    out_.special.scalars = scalars;
    int map = -2;
    for (const shader::VolumeView& v : fields_) out_.special.byCells |= uint32_t(v.byCells);
    for (const shader::OperatorView& op : operators_) {
      const int mine = op.map.intervals <= MAP_SMALL ? MAP_KIND_SMALL
                       : op.map.uniformIntervals > 0 ? MAP_KIND_UNIFORM
                                                     : MAP_KIND_BUCKETS;
      map = map == -2 || map == mine ? mine : -1;
    }
    out_.special.mapKind = std::max(map, -1);
    // Picking from many registers is worth it only where lanes fetch one after the other.
    if (device_.endsLoops() && scene_.rendered.size() == 1) {
      const int intervals = operators_[size_t(scene_.rendered[0])].map.intervals;
      out_.special.mapAhead = intervals <= 4 ? 4 : intervals <= 8 ? 8 : 0;
    }
    // Several operators are read ahead only where that is cheaper than reading the one that is needed.
    const size_t readAhead = device_.endsLoops() ? FEW_OPERATORS : 1;
    const size_t n = fields_.size();
    out_.special.operators = n == 1 ? 1 : n <= readAhead ? FEW_OPERATORS : 0;
    // Drivers may or may not leave out reads that nothing uses, so there must be something to read.
    operators_.resize(std::max<size_t>(n, FEW_OPERATORS));
    fields_.resize(operators_.size());
  }

  const Device& device_;
  const CompiledScene& scene_;
  const int partition_;
  const Advance& advance_;
  bool isScene_ = true;  // whether a scene accounts for what is made
  PartitionOnDevice out_;
  Words tables_;
  Places inTables_{tables_};
  std::vector<const GeometryInPartition*> primitives_;  // geometryOf()
  shader::SceneView view_{};
  std::vector<shader::OperatorView> operators_;
  std::vector<shader::VolumeView> fields_;
};

}  // namespace

void checkNumbering(const Index3& points, int components) {
  const auto n = int64_t(Bricks(points).count());
  if (n > int64_t(1) << 31 || n * components > int64_t(1) << 32)
    throw Error("a volume has " + std::to_string(n) + " points of " + std::to_string(components) +
                " components in the bricks of one partition, expected up to 2^31 points and 2^32 numbers; "
                "cut it into more partitions");
}

void expectRoom(const Device& device, const SharedData& shared, const CompiledScene& scene,
                std::span<const int> partitions) {
  std::vector<size_t> sizes;
  const auto add = [&](const auto& all, const auto& sharedBy, const auto& bytesOf) {
    size_t bytes = 0;
    for (const auto* one : all) bytes += one ? bytesOf(*one) : 0;
    if (bytes > 0 && !sharedBy.has(all)) sizes.push_back(bytes);
  };
  for (const int p : partitions) {
    add(blocksOf(scene.operators, p), shared.samples,
        [](const VolumeBlock& block) { return block.samples.size(); });
    add(geometryOf(scene, p), shared.geometry, [](const GeometryInPartition& part) {
      return part.bytes() + (part.cells ? part.cells->bytes() : 0);
    });
  }
  if (sizes.size() > 1) device.expectRoom(sizes, "the scene's volumes and geometry");
}

PartitionOnDevice uploadFields(const Device& device, const Pipelines& pipelines, SharedData& shared,
                               const CompiledSampling& sampling, int partition, int rank) {
  const Advance advance = [](double) {};
  return Uploading(device, sampling, partition, rank, advance).finish(pipelines, shared);
}

PartitionOnDevice uploadPart(const Device& device, const Pipelines& pipelines, SharedData& shared,
                             const CompiledScene& scene, int partition, int rank, const Advance& advance) {
  return Uploading(device, scene, partition, rank, advance).finish(pipelines, shared);
}

}  // namespace gxy::vulkan
