#include "scene/gltf_animation.hpp"

#include "scene/gltf_accessor.hpp"
#include "scene/gltf_keyframes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

namespace raig::gltf {

namespace {

using Json = nlohmann::json;

/// Any number of channels may name the same accessors, each of which reads them.
constexpr size_t mostNumbers = size_t{1} << 28;

std::string textIn(const Json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

/// The elements of an array; none if it is absent.
const Json& arrayIn(const Json& object, const char* name) {
    static const Json none = Json::array();
    const auto found = object.find(name);
    return found == object.end() ? none : *found;
}

std::string namesOf(const std::vector<Clip>& clips) {
    constexpr size_t shown = 20;
    std::string names;
    for (size_t i = 0; i < std::min(clips.size(), shown); ++i)
        names += fmt::format("{}{} {}", i ? ", " : "", i, clips[i].name.empty() ? "(unnamed)" : clips[i].name);
    return clips.size() > shown ? fmt::format("{} and {} more", names, clips.size() - shown) : names;
}

/// The animation of that name or, if there is none, that index; the first if nothing is wanted.
size_t chooseAnimation(const Document& document, const std::string& wanted) {
    const std::vector<Clip> clips = listAnimations(document);
    if (clips.empty()) throw usageError("--time-at and --frames: {} has no animation: nothing moves in it", document.file);
    if (wanted.empty()) return 0;
    for (size_t i = 0; i < clips.size(); ++i)
        if (clips[i].name == wanted) return i;
    size_t index = 0;
    const char* const end = wanted.data() + wanted.size();
    const auto [last, fault] = std::from_chars(wanted.data(), end, index);
    if (fault == std::errc{} && last == end && index < clips.size()) return index;
    throw usageError("--animation {}: {} has no such animation; it has: {}", wanted, document.file, namesOf(clips));
}

/// Plays one animation: reads its channels and sets nodes.
class Player {
public:
    Player(Document& document, size_t animation, double seconds, Remarks& remarks)
        : document_(document),
          source_(document.animations[animation]),
          pointer_(fmt::format("/animations/{}", animation)),
          seconds_(seconds),
          remarks_(remarks) {}

    void play() {
        const size_t channels = arrayIn(source_, "channels").size();
        if (channels == 0) remarks_.add("the animation that is played moves nothing");
        for (size_t i = 0; i < channels; ++i) playChannel(i);
    }

private:
    void playChannel(size_t channel);
    void setTransform(tinygltf::Node& node, const std::string& path, const Json& sampler, const std::string& place);
    void setWeights(tinygltf::Node& node, const Json& sampler, const std::string& place);

    /// A sampler's numbers, which the keyframes point into.
    struct Track {
        std::vector<float> times, values;
        Keyframes keyframes;
    };
    Track readTrack(const Json& sampler, const std::string& place, size_t width, int components, bool mayBeIntegers);
    std::vector<float> readTimes(const Json& sampler, const std::string& place);
    std::vector<double> valueOf(const Json& sampler, const std::string& place, size_t width, int components,
                                bool mayBeIntegers);

    /// A member that must be there and below `count`.
    size_t indexIn(const Json& object, const char* name, const char* kind, size_t count, const std::string& place) const;
    std::vector<float> read(int accessor, const std::string& place);

    Document& document_;
    const Json& source_;
    std::string pointer_;
    double seconds_;
    Remarks& remarks_;
    std::set<std::pair<size_t, std::string>> moved_;
    size_t numbers_ = 0;
};

size_t Player::indexIn(const Json& object, const char* name, const char* kind, size_t count,
                       const std::string& place) const {
    const auto found = object.find(name);
    if (found == object.end()) throw errorAt(document_, place, "names no {}", name);
    const std::string pointer = place + "/" + name;
    const size_t index = wholeNumber(document_, *found, pointer);
    if (index >= count) throw errorAt(document_, pointer, "names {} {}, but there are {}", kind, index, count);
    return index;
}

std::vector<float> Player::read(int accessor, const std::string& place) {
    const tinygltf::Accessor& source = document_.model.accessors[accessor];
    const size_t components = componentCount(source.type);
    // An element takes a byte at least, so the product cannot overflow.
    numbers_ += source.count * components;
    if (numbers_ > mostNumbers)
        throw limitError("{}#{}: the animation's channels read more than {} numbers", document_.file, place, mostNumbers);
    std::vector<float> values = readFloats(document_, accessor);
    for (size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i])) throw errorAt(document_, place, "element {} is not finite", i / components);
    return values;
}

std::vector<float> Player::readTimes(const Json& sampler, const std::string& place) {
    const std::string input = place + "/input";
    const size_t accessor = indexIn(sampler, "input", "accessor", document_.model.accessors.size(), place);
    checkType(document_, static_cast<int>(accessor),
              {.components = 1,
               .bytes = false,
               .unsignedBytes = false,
               .shorts = false,
               .unsignedShorts = false,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = false},
              input);
    std::vector<float> times = read(static_cast<int>(accessor), input);
    if (times.empty()) throw errorAt(document_, input, "has no keyframes");
    if (times[0] < 0.0f) throw errorAt(document_, input, "keyframe 0 is at {} s, before the start", times[0]);
    for (size_t i = 1; i < times.size(); ++i)
        if (!(times[i] > times[i - 1]))
            throw errorAt(document_, input, "keyframe {} at {} s does not come after the one before, at {} s", i, times[i],
                          times[i - 1]);
    return times;
}

Player::Track Player::readTrack(const Json& sampler, const std::string& place, size_t width, int components,
                                bool mayBeIntegers) {
    Track track;
    const std::string kind = sampler.contains("interpolation") ? textIn(sampler, "interpolation") : "LINEAR";
    if (kind != "LINEAR" && kind != "STEP" && kind != "CUBICSPLINE")
        throw errorAt(document_, place + "/interpolation", "is '{}'; LINEAR, STEP and CUBICSPLINE are known",
                      printable(kind));
    track.times = readTimes(sampler, place);
    const std::string output = place + "/output";
    const size_t accessor = indexIn(sampler, "output", "accessor", document_.model.accessors.size(), place);
    checkType(document_, static_cast<int>(accessor),
              {.components = components,
               .bytes = mayBeIntegers,
               .unsignedBytes = mayBeIntegers,
               .shorts = mayBeIntegers,
               .unsignedShorts = mayBeIntegers,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = true},
              output);
    const bool isSpline = kind == "CUBICSPLINE";
    const size_t wanted = track.times.size() * (isSpline ? 3 : 1) * (width / static_cast<size_t>(components));
    const size_t count = document_.model.accessors[accessor].count;
    if (count != wanted)
        throw errorAt(document_, output, "has {} elements for {} keyframes, which need {}", count, track.times.size(),
                      wanted);
    if (isSpline && track.times.size() < 2) throw errorAt(document_, place, "is a spline of one keyframe; it needs two");
    track.values = read(static_cast<int>(accessor), output);
    track.keyframes = {isSpline         ? Interpolation::cubicSpline
                       : kind == "STEP" ? Interpolation::step
                                        : Interpolation::linear,
                       width, track.times, track.values};
    return track;
}

std::vector<double> Player::valueOf(const Json& sampler, const std::string& place, size_t width, int components,
                                    bool mayBeIntegers) {
    return valueAt(readTrack(sampler, place, width, components, mayBeIntegers).keyframes, seconds_);
}

void Player::setTransform(tinygltf::Node& node, const std::string& path, const Json& sampler, const std::string& place) {
    if (path != "rotation") {
        (path == "scale" ? node.scale : node.translation) = valueOf(sampler, place, 3, 3, false);
        return;
    }
    const dvec4 q = rotationAt(readTrack(sampler, place, 4, 4, true).keyframes, seconds_);
    if (!std::isfinite(glm::dot(q, q)))
        throw errorAt(document_, place + "/output", "the rotation at {} s is zero: a quaternion needs a length", seconds_);
    node.rotation = {q.x, q.y, q.z, q.w};
}

void Player::setWeights(tinygltf::Node& node, const Json& sampler, const std::string& place) {
    node.weights = valueOf(sampler, place, targetCount(document_.model.meshes[node.mesh]), 1, true);
}

void Player::playChannel(size_t channel) {
    const std::string place = fmt::format("{}/channels/{}", pointer_, channel);
    const Json& source = arrayIn(source_, "channels")[channel];
    const Json& samplers = arrayIn(source_, "samplers");
    const size_t sampler = indexIn(source, "sampler", "sampler", samplers.size(), place);
    if (!source.contains("target")) throw errorAt(document_, place, "has no target");
    const Json& target = source["target"];
    const std::string path = textIn(target, "path");
    if (path.empty()) throw errorAt(document_, place + "/target", "has no path");
    const bool isTransform = path == "translation" || path == "rotation" || path == "scale";
    if (!isTransform && path != "weights")
        return remarks_.add(fmt::format("an animation of '{}' is not played", printable(path)));
    if (!target.contains("node")) return remarks_.add("an animation of what is no node is not played");
    const size_t index = indexIn(target, "node", "node", document_.model.nodes.size(), place + "/target");
    if (!moved_.insert({index, path}).second)
        throw errorAt(document_, place + "/target", "node {}'s {} has another channel already", index, path);
    tinygltf::Node& node = document_.model.nodes[index];
    const std::string samplerPlace = fmt::format("{}/samplers/{}", pointer_, sampler);
    if (isTransform) {
        if (!node.matrix.empty())
            throw errorAt(document_, place + "/target", "node {} has a matrix, and no {} to be animated", index, path);
        return setTransform(node, path, samplers[sampler], samplerPlace);
    }
    if (node.mesh < 0 || targetCount(document_.model.meshes[node.mesh]) == 0)
        throw errorAt(document_, place + "/target", "node {} has no morph targets to be weighted", index);
    setWeights(node, samplers[sampler], samplerPlace);
}

}  // namespace

std::vector<Clip> listAnimations(const Document& document) {
    std::vector<Clip> clips;
    const auto& accessors = document.model.accessors;
    for (const Json& animation : document.animations) {
        Clip clip{printable(textIn(animation, "name")), 0.0};
        for (const Json& sampler : arrayIn(animation, "samplers")) {
            const auto found = sampler.find("input");
            if (found == sampler.end() || !found->is_number_unsigned()) continue;
            const auto input = found->get<size_t>();
            if (input >= accessors.size() || accessors[input].maxValues.size() != 1) continue;
            const double last = accessors[input].maxValues[0];
            if (last > clip.seconds && std::isfinite(last)) clip.seconds = last;
        }
        clips.push_back(std::move(clip));
    }
    return clips;
}

void pose(Document& document, const Moment& moment, Remarks& remarks) {
    if (!moment.seconds) {
        if (!document.animations.empty())
            remarks.add("animations are not played: without a moment (--time-at), everything is in its rest pose",
                        document.animations.size());
        return;
    }
    const size_t animation = chooseAnimation(document, moment.animation);
    if (document.animations.size() > 1 && moment.animation.empty())
        remarks.add(
            fmt::format("of {} animations, animation 0 is played (--animation names another)", document.animations.size()));
    Player(document, animation, *moment.seconds, remarks).play();
}

}  // namespace raig::gltf
