<?php

declare(strict_types=1);

namespace OCA\Overcoat\AppInfo;

use OCA\Overcoat\Preview;
use OCP\AppFramework\App;
use OCP\AppFramework\Bootstrap\IBootContext;
use OCP\AppFramework\Bootstrap\IBootstrap;
use OCP\AppFramework\Bootstrap\IRegistrationContext;

class Application extends App implements IBootstrap {
    public function __construct(array $urlParams = []) {
        parent::__construct('overcoat', $urlParams);
    }

    public function register(IRegistrationContext $context): void {
        $context->registerPreviewProvider(Preview::class, Preview::TYPES);
    }

    public function boot(IBootContext $context): void {
    }
}
