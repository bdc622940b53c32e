#include "kinetostat/apps/studio/studio_server.h"

#include <chrono>
#include <cstdint>
#include <httplib.h>
#include <mutex>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "kinetostat/common/error.h"

namespace kinetostat::apps {
namespace {

using io::Json;

constexpr char loopback[] = "127.0.0.1";
constexpr std::size_t request_threads = 16;  // one browser needs six

// 128 bits of the system's own randomness: this is no figure that must come out the same.
std::string random_token() {
  std::random_device device;
  std::string token;
  for (int k = 0; k < 4; ++k) token += fmt::format("{:08x}", device());
  return token;
}

// In a time that does not depend on where they differ.
bool equal(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

// "/TOKEN/fit" -> "TOKEN".
std::string_view token_in(std::string_view path) {
  if (!path.starts_with('/')) return {};
  path.remove_prefix(1);
  const std::size_t end = path.find('/');
  return end == std::string_view::npos ? std::string_view() : path.substr(0, end);
}

// With its character set named, because the library would compress the bare type, which takes
// longer than the work that is answered.
void answer(httplib::Response& response, int status, const Json& json) {
  response.status = status;
  response.set_content(json.dump(-1, ' ', false, Json::error_handler_t::replace),
                       "application/json; charset=utf-8");
}

void refuse(httplib::Response& response, int status, const std::string& why) {
  answer(response, status, {{"error", why}});
}

std::size_t length_of(const httplib::Request& request) {
  return request.get_header_value<std::uint64_t>("Content-Length");
}

class Door {
 public:
  Door(const StudioRooms& rooms, int port) : rooms_(rooms), token_(random_token()) {
    server_.new_task_queue = [] { return new httplib::ThreadPool(request_threads); };
    server_.set_payload_max_length(studio_largest_file);
    server_.set_read_timeout(std::chrono::seconds(studio_read_seconds));
    server_.set_keep_alive_max_count(1);
    server_.set_keep_alive_timeout(studio_keep_alive_seconds);
    server_.set_socket_options([](auto) {});  // a port that somebody listens on is not shared
    server_.set_pre_routing_handler([this](const auto& request, auto& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server_.set_exception_handler([](const auto&, auto& response, const std::exception_ptr&) {
      refuse(response, 500, "the request could not be answered");
    });
    server_.set_error_handler([](const auto&, auto& response) {
      if (response.body.empty()) refuse(response, response.status, "there is nothing here");
    });
    server_.Get("/" + token_ + "/", [this](const auto&, auto& response) { send_page(response); });
    for (const auto& [name, action] : rooms_.actions)
      server_.Post("/" + token_ + "/" + name,
                   [this, &action = action](const auto& request, auto& response) {
                     act(request, response, [&](const Json& json) { return action(json); });
                   });
    for (const auto& [name, job] : rooms_.jobs)
      server_.Post("/" + token_ + "/" + name, [this, name = name, &job = job](const auto& request,
                                                                              auto& response) {
        act(request, response, [&](const Json& json) {
          job_.start(name, [this, &job, json](common::Progress&) { return job(json, job_); });
          return job_.status();
        });
      });
    server_.Post("/" + token_ + "/progress",
                 [this](const auto&, auto& response) { answer(response, 200, job_.status()); });
    server_.Post("/" + token_ + "/stop", [this](const auto&, auto& response) {
      job_.stop();
      answer(response, 200, job_.status());
    });
    server_.set_default_headers({{"X-Content-Type-Options", "nosniff"},
                                 {"X-Frame-Options", "DENY"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cache-Control", "no-store"}});
    port_ = port == 0 ? server_.bind_to_any_port(loopback)
                      : (server_.bind_to_port(loopback, port) ? port : -1);
    if (port_ <= 0)
      throw common::InputError("--port", fmt::format("{} cannot be listened on", port),
                               "Leave it out, then a free one is taken");
  }

  std::string origin() const { return fmt::format("http://{}:{}", loopback, port_); }
  std::string address() const { return fmt::format("{}/{}/", origin(), token_); }
  void listen() { server_.listen_after_bind(); }
  void stop() {
    job_.stop();
    server_.stop();
  }
  bool runs() const { return server_.is_running(); }

 private:
  // Another host name: a name that was made to lead here. Another origin: another page's script.
  bool admit(const httplib::Request& request, httplib::Response& response) const {
    const std::string host = request.get_header_value("Host");
    const bool from_here =
        !request.has_header("Origin") || request.get_header_value("Origin") == origin();
    if (host != fmt::format("{}:{}", loopback, port_) || !from_here ||
        request.get_header_value("Sec-Fetch-Site") == "cross-site") {
      refuse(response, 403, "only the page of this server may ask");
      return false;
    }
    if (!equal(token_in(request.path), token_)) {
      refuse(response, 403, "the address does not hold the token of this session");
      return false;
    }
    // A server may answer with all of it (RFC 9110, section 14.2); thousands of parts of a page
    // would be as many copies.
    if (request.ranges.size() > 1) {
      refuse(response, 416, "the page comes as a whole");
      return false;
    }
    if (!request.path.ends_with("/drop") && length_of(request) > studio_largest_request) {
      response.set_header("Connection", "close");
      refuse(response, 413, "a request is larger than anything that the page asks");
      return false;
    }
    // Its size would be known only when it is too late.
    if (request.has_header("Transfer-Encoding")) {
      response.set_header("Connection", "close");
      refuse(response, 411, "a request must say its length");
      return false;
    }
    return true;
  }

  // In pieces of a stated length, which the library leaves as they are: it takes seconds to make
  // less of what stays on this machine.
  void send_page(httplib::Response& response) const {
    response.set_content_provider(
        rooms_.page.size(), "text/html; charset=utf-8",
        [this](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
          return sink.write(rooms_.page.data() + offset, length);
        });
  }

  template <class Action>
  void act(const httplib::Request& request, httplib::Response& response, const Action& action) {
    const Json json = Json::parse(request.body, nullptr, false);
    if (!json.is_object()) return refuse(response, 400, "the request is not a JSON object");
    const std::scoped_lock lock(busy_);
    if (job_.runs()) return refuse(response, 503, "other work is under way");
    try {
      answer(response, 200, action(json));
    } catch (const std::bad_alloc&) {
      refuse(response, 507, "there is not enough memory for this: close other programs");
    } catch (const std::exception& error) {
      refuse(response, 422, error.what());
    }
  }

  const StudioRooms& rooms_;
  std::string token_;
  httplib::Server server_;
  std::mutex busy_;
  int port_ = -1;
  StudioJob job_;  // ends before what it uses
};

}  // namespace

void serve_studio(const StudioRooms& rooms, const StudioOptions& options) {
  Door door(rooms, options.port);
  options.opened(door.address());
  std::jthread watch([&](const std::stop_token& over) {
    while (!over.stop_requested()) {
      if (options.stopped()) door.stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  });
  if (!options.stopped()) door.listen();
}

}  // namespace kinetostat::apps
