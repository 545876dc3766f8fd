// SPDX-License-Identifier: Apache-2.0
// What a dataset is now, kept under another name. The copy shares the data, which never change.
#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/session.h"

namespace gxy {

using nlohmann::json;

json Datasets::copyHere(const json& p) {
  const auto exchange = p.at("exchange").get<uint64_t>();
  Exchanges::Part part = serverRank_.exchanges.join(exchange);
  Publication publication = join(p.at("items"), part.ranks);
  publication.reserve();
  agree(part.ranks, [&] {
    const Pin pin =
        serverRank_.objects.pin(Key{p.at("key").get<uint64_t>()}, p.at("generation").get<Generation>());
    const auto original = pin.get<Dataset>();
    const auto copy = std::make_shared<Dataset>();
    // What filters have made and simulations have published has no file to be read again, and must not be made again.
    if (!original->file.empty()) {
      copy->file = original->file;
      copy->array = original->array;
      copy->radiusArray = original->radiusArray;
      copy->fields = original->fields;
    }
    copy->color = original->color;
    copy->partitioning = original->partitioning;
    copy->volume = original->volume;
    copy->mesh = original->mesh;
    copy->geometry = original->geometry;
    copy->time = original->time;
    // Its own source, as what is imported: filters may compare it with newer steps of the original.
    const Publication::Item& item = publication.items().front();
    copy->origins = {{item.key.value, int64_t(item.generation)}};
    copy->bytes = original->bytes;
    copy->sharedMemory = original->sharedMemory;
    copy->memory = serverRank_.takeMemory(
        p.at("tenant").get<std::string>(), original->geometry ? "geometry" : "volume",
        original->sharedMemory && original->mesh ? bytesOfValues(*original->mesh) : original->bytes);
    publication.stage(0, Payload(std::shared_ptr<const Dataset>(copy)));
  });
  publish(publication, exchange);
  return nullptr;
}

json Datasets::copy(Request& request, const std::string& name, const std::string& newName, Scope scope) {
  if (name == newName)
    throw Error("copy: both names are " + inQuotes(newName) + ", expected another one for the copy");
  const std::string& tenant = request.session().tenant();
  const auto exchange = serverRank_.exchanges.begin(request);
  const DatasetType type = datasetTypeNamed(get(tenant, name).type).value();
  const auto names = begin(request, *exchange, "copy", scope, {{newName, type}});
  const auto [original, pin] = getPinned(tenant, name);
  if (original.type != gxy::nameOf(type))
    throw Error("copy: " + inQuotes(name) + " is of type " + original.type + " by now, it was " +
                gxy::nameOf(type) + "; try again");
  try {
    serverRank_.callAll("datasets.copy", {{"exchange", *exchange},
                                          {"tenant", tenant},
                                          {"items", names->items()},
                                          {"key", original.key.value},
                                          {"generation", original.generation}});
  } catch (const Error&) {
    check(*names);  // if a name is why, this says more
    throw;
  }
  json told{{"generation", names->drafts().front().generation}};
  if (const json origin = originOf(*pin.get<Dataset>()); !origin.is_null()) told.update(origin);
  return told;
}

}  // namespace gxy
