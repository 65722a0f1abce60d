#pragma once

enum wifi_mode_t { WIFI_MODE_NULL, WIFI_MODE_STA };
#define WIFI_STA WIFI_MODE_STA

struct Network {
  bool mode(wifi_mode_t mode);
};
extern Network WiFi;
