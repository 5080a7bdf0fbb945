<?php

declare(strict_types=1);

namespace OCA\Overcoat;

use OCP\Files\File;
use OCP\Files\FileInfo;
use OCP\Http\Client\IClientService;
use OCP\IConfig;
use OCP\IImage;
use OCP\Image;
use OCP\Preview\IProviderV2;
use Psr\Log\LoggerInterface;

/** Previews of models by overcoat-service. */
class Preview implements IProviderV2 {
    public const TYPES = '/^model\/.+/';

    public function __construct(
        private IConfig $config,
        private IClientService $clients,
        private LoggerInterface $logger,
    ) {
    }

    public function getMimeType(): string {
        return self::TYPES;
    }

    public function isAvailable(FileInfo $file): bool {
        // As the service's --max-body.
        return $file->getSize() > 0 && $file->getSize() <= 64 << 20;
    }

    public function getThumbnail(File $file, int $maxX, int $maxY): ?IImage {
        $url = rtrim($this->config->getSystemValueString('overcoat_url', 'http://127.0.0.1:8080'), '/');
        // Nextcloud makes all smaller sizes of the largest one itself.
        $side = max(1, min($maxX, $maxY, $this->config->getSystemValueInt('overcoat_size', 1024)));
        $headers = ['Accept' => 'image/png'];
        $key = $this->config->getSystemValueString('overcoat_key', '');
        if ($key !== '') {
            $headers['Authorization'] = "Bearer $key";
        }
        try {
            $response = $this->clients->newClient()->post("$url/render", [
                'query' => ['size' => $side, 'name' => $file->getName()],
                'headers' => $headers,
                'body' => $file->fopen('r'),
                'timeout' => 120,
                'connect_timeout' => 3,
                'nextcloud' => ['allow_local_address' => true],
            ]);
        } catch (\Throwable $error) {
            $this->logger->info("No preview of {$file->getName()}: {$error->getMessage()}", ['app' => 'overcoat']);
            return null;
        }
        $image = new Image();
        $image->loadFromData($response->getBody());
        return $image->valid() ? $image : null;
    }
}
