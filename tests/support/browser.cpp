#include "support/browser.hpp"

#include "support/effort.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace raig {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* chromium = "/usr/lib/chromium/chromium";  // what Debian's script of that name starts
constexpr int patience = 30 * static_cast<int>(test::slowdown);

std::runtime_error trouble(const std::string& what) {
    return std::runtime_error("the browser " + what);
}

std::vector<std::byte> decoded(const std::string& base64) {
    static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<std::byte> bytes;
    uint32_t bits = 0, count = 0;
    for (const char c : base64) {
        const size_t digit = digits.find(c);
        if (digit == std::string::npos) break;  // padding
        bits = bits << 6 | static_cast<uint32_t>(digit);
        if ((count += 6) >= 8) bytes.push_back(static_cast<std::byte>(bits >> (count -= 8) & 255u));
    }
    return bytes;
}

}  // namespace

std::optional<std::string> Browser::program() {
    return ::access(chromium, X_OK) == 0 ? std::optional<std::string>(chromium) : std::nullopt;
}

Browser::Browser() {
    std::string name = (fs::temp_directory_path() / "raig-browser-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw trouble("gets no folder");
    folder = name;
    std::array<int, 2> commands{}, answers{};
    if (::pipe2(commands.data(), O_CLOEXEC) != 0 || ::pipe2(answers.data(), O_CLOEXEC) != 0) throw trouble("gets no pipe");
    std::signal(SIGPIPE, SIG_IGN);  // a browser that has ended is an error, not the end of the test
    process = ::fork();
    if (process < 0) throw trouble("cannot be forked");
    if (process == 0) become(commands[0], answers[1]);
    ::close(commands[0]);
    ::close(answers[1]);
    commandPipe = commands[1];
    answerPipe = answers[0];
    try {
        const json target = call("Target.createTarget", {{"url", "about:blank"}});
        session = call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}}).at("sessionId");
        for (const char* domain : {"Page", "Runtime", "Log", "Network"}) call(domain + std::string(".enable"));
        call("Page.setLifecycleEventsEnabled", {{"enabled", true}});
    } catch (...) {
        stop();
        throw;
    }
}

/// In the child: becomes the browser, which reads commands from descriptor 3 and answers on 4.
void Browser::become(int commands, int answers) const {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    // Out of the way first: either may be 3 or 4 itself.
    const int in = ::fcntl(commands, F_DUPFD_CLOEXEC, 10), out = ::fcntl(answers, F_DUPFD_CLOEXEC, 10);
    const int none = ::open("/dev/null", O_RDWR);
    if (in < 0 || out < 0 || none < 0) ::_exit(127);
    for (const auto& [from, to] :
         {std::pair(none, 0), std::pair(none, 1), std::pair(none, 2), std::pair(in, 3), std::pair(out, 4)})
        if (::dup2(from, to) < 0) ::_exit(127);
    for (const char* home : {"HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"}) ::setenv(home, folder.c_str(), 1);
    const std::string profile = "--user-data-dir=" + (folder / "profile").string();
    ::execl(chromium, chromium, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
            "--disable-background-networking", "--disable-component-update", "--hide-scrollbars", "--remote-debugging-pipe",
            profile.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
}

Browser::~Browser() {
    stop();
}

void Browser::stop() {
    ::kill(-process, SIGKILL);  // it and its children
    ::kill(process, SIGKILL);   // it, where it has not yet come to lead a group
    ::waitpid(process, nullptr, 0);
    ::close(commandPipe);
    ::close(answerPipe);
    // Its children end with it, but not at the same instant: they may still be writing.
    std::error_code failed;
    for (int i = 0; i < 50 && (fs::remove_all(folder, failed), failed); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

json Browser::receive() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(patience);
    size_t length = 0;
    while ((length = unread.find('\0')) == std::string::npos) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
        pollfd ready{answerPipe, POLLIN, 0};
        if (left.count() <= 0 || ::poll(&ready, 1, static_cast<int>(left.count())) == 0) throw trouble("does not answer");
        std::array<char, 65536> buffer{};
        const ssize_t count = ::read(answerPipe, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) throw trouble("has ended");
        unread.append(buffer.data(), static_cast<size_t>(count));
    }
    const json message = json::parse(unread.substr(0, length));
    unread.erase(0, length + 1);
    return message;
}

json Browser::call(const std::string& method, const json& parameters) {
    json command = {{"id", ++lastCall}, {"method", method}, {"params", parameters}};
    if (!session.empty()) command["sessionId"] = session;
    const std::string text = command.dump() + '\0';
    for (size_t at = 0; at < text.size();) {
        const ssize_t count = ::write(commandPipe, text.data() + at, text.size() - at);
        if (count <= 0) throw trouble("takes no commands");
        at += static_cast<size_t>(count);
    }
    for (;;) {
        const json message = receive();
        if (!message.contains("id")) notice(message);
        if (message.value("id", 0) != lastCall) continue;
        if (message.contains("error")) throw trouble("says of " + method + ": " + message["error"].dump());
        return message.at("result");
    }
}

void Browser::notice(const json& event) {
    const std::string method = event.value("method", "");
    const json parameters = event.value("params", json::object());
    if (method == "Page.lifecycleEvent" && parameters.at("name") == "load") loaded = parameters.at("loaderId");
    if (method == "Runtime.exceptionThrown") errors.push_back(parameters.at("exceptionDetails").dump());
    if (method == "Runtime.consoleAPICalled" && parameters.at("type") == "error")
        errors.push_back(parameters.at("args").dump());
    if (method == "Log.entryAdded" && parameters.at("entry").at("level") == "error")
        errors.push_back(parameters.at("entry").at("text"));
    if (method != "Network.requestWillBeSent") return;
    const std::string address = parameters.at("request").at("url");
    if (address != shown && !address.starts_with("data:")) asked.push_back(address);
}

void Browser::open(const fs::path& page, const BrowserView& view) {
    call("Emulation.setDeviceMetricsOverride",
         {{"width", view.width}, {"height", view.height}, {"deviceScaleFactor", 1}, {"mobile", false}});
    call("Emulation.setEmulatedMedia",
         {{"features", {{{"name", "prefers-color-scheme"}, {"value", view.isDark ? "dark" : "light"}}}}});
    call("Emulation.setScriptExecutionDisabled", {{"value", !view.hasScript}});
    shown = "file://";
    for (const char c : fs::absolute(page).string())
        shown += std::isalnum(static_cast<unsigned char>(c)) || std::strchr("/-_.", c)
                     ? std::string(1, c)
                     : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    errors.clear();
    asked.clear();
    const json result = call("Page.navigate", {{"url", shown}});
    if (result.contains("errorText")) throw trouble("cannot open " + shown + ": " + result["errorText"].dump());
    while (loaded != result.at("loaderId")) notice(receive());
}

json Browser::evaluate(const std::string& expression) {
    const json result =
        call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
    if (result.contains("exceptionDetails")) throw trouble("cannot evaluate: " + result["exceptionDetails"].dump());
    return result.at("result").value("value", json());
}

void Browser::mouse(const char* type, double x, double y, int buttons) {
    const bool isButton = std::string(type) != "mouseMoved";
    call("Input.dispatchMouseEvent", {{"type", type},
                                      {"x", x},
                                      {"y", y},
                                      {"button", isButton || buttons ? "left" : "none"},
                                      {"buttons", buttons},
                                      {"clickCount", isButton ? 1 : 0}});
}

void Browser::click(double x, double y) {
    drag(x, y, x, y);
}

void Browser::drag(double fromX, double fromY, double toX, double toY) {
    mouse("mouseMoved", fromX, fromY, 0);
    mouse("mousePressed", fromX, fromY, 1);
    if (fromX != toX || fromY != toY)
        for (const double part : {0.25, 0.5, 0.75, 1.0})
            mouse("mouseMoved", fromX + part * (toX - fromX), fromY + part * (toY - fromY), 1);
    mouse("mouseReleased", toX, toY, 0);
}

void Browser::press(const std::string& key) {
    const int code = key == "ArrowLeft" ? 37 : key == "ArrowRight" ? 39 : key == "Tab" ? 9 : 13;
    json event = {{"type", "keyDown"}, {"key", key}, {"code", key}, {"windowsVirtualKeyCode", code}};
    if (key == "Enter") event["text"] = "\r";
    call("Input.dispatchKeyEvent", event);
    event["type"] = "keyUp";
    event.erase("text");
    call("Input.dispatchKeyEvent", event);
}

void Browser::screenshot(const fs::path& file) {
    const std::vector<std::byte> png =
        decoded(call("Page.captureScreenshot", {{"format", "png"}, {"captureBeyondViewport", true}}).at("data"));
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
}

}  // namespace raig
